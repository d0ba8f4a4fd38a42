#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "graph/channel/channel_counts.hpp"
#include "graph/channel/latched_messages.hpp"
#include "graph/channel/message_numbers.hpp"
#include "graph/channel/publication.hpp"
#include "graph/channel/publish_rate.hpp"
#include "graph/channel/raw_forms.hpp"
#include "graph/channel/raw_presence.hpp"
#include "graph/channel/room_signal.hpp"
#include "graph/nodes/node.hpp"
#include "graph/nodes/node_stats.hpp"
#include "hgros/graph/data_graph.hpp"
#include "hgros/graph/publisher.hpp"
#include "hgros/internal/graph/outlet.hpp"

namespace hgros {

class GraphCore;

// A typed hyperedge.
//
// Thread safety: all public functions may be called from any thread.
// Invariants: fanout_ and outlet_ are read under an epoch guard and replaced under wiring_mutex_. A new node gets each
// latched message exactly once: a publisher stores the message and reads the list of nodes under latch_mutex_, and a
// node gets the stored messages and is added under the same lock. A message that is not wrapped (two_forms) is of
// type_; a raw one is always wrapped.
class Channel {
 public:
  Channel(std::string name, const TypeInfo& type, std::string declared_at, GraphCore& core);
  Channel(const Channel&) = delete;
  Channel& operator=(const Channel&) = delete;
  ~Channel();

  PublishStatus Publish(const MessageOffer& offer, Reach reach) noexcept;
  PublishStatus PublishWait(const MessageOffer& offer, Reach reach, std::chrono::steady_clock::time_point deadline,
                            const std::stop_token& stop);
  void CountRefused() noexcept { counts_.refused.fetch_add(1, std::memory_order_relaxed); }
  // `type` is one of the channel's types.
  [[nodiscard]] bool Inject(AnyMessage message, const TypeInfo& type, const MessageInfo& info,
                            std::shared_ptr<const void> credit, std::size_t latched, UserCode user_code) noexcept;
  [[nodiscard]] const TypeInfo& InboundType() const noexcept;

  // Returns whether the channel can be used with `type`: its first type, the second C++ type of the same wire form, or
  // AnyType(). The first request for a second type adds it; a channel that only had AnyType() gets `type`. A type that
  // is known at run time only fits if it is interchangeable with the channel's; a C++ type takes its place. `where` is
  // the place of the request, for errors.
  [[nodiscard]] bool TryUseWith(const TypeInfo& type, const CallSite& where);
  // A message of this channel as `type`, one of its types; null if that fails. Converted at most once for all nodes.
  [[nodiscard]] AnyMessage InForm(const AnyMessage& message, const TypeInfo& type);

  void Add(const std::shared_ptr<Node>& node);
  void Remove(const Node& node);
  void SetOutlet(std::shared_ptr<Outlet> outlet);
  void Latch(std::size_t count);
  // See DataGraph.
  void ReplaceLatched(std::vector<AnyMessage> messages, const TypeInfo& type, std::uint64_t other);
  [[nodiscard]] bool ForgetRemoteLatched();
  // While a remote publisher is gone, new nodes get none of its latched messages; they get them when it is back.
  void PublisherIsGone(std::uint64_t publisher);
  // `incarnation`: of its next message, if that has come first and waits for this.
  void PublisherIsBack(std::uint64_t publisher, std::optional<std::uint64_t> incarnation = std::nullopt);
  void SetClosed(bool closed) noexcept { closed_.store(closed, std::memory_order_relaxed); }
  void NotifyRoom() noexcept { room_.Notify(); }

  [[nodiscard]] std::vector<std::shared_ptr<Node>> Nodes() const;
  [[nodiscard]] std::size_t NextNodeNumber() noexcept { return next_node_number_++; }
  [[nodiscard]] bool HasOutlet() const noexcept { return outlet_.load(std::memory_order_acquire) != nullptr; }
  [[nodiscard]] ThreadUse UseOfThread() const noexcept;
  [[nodiscard]] ChannelSnapshot Snapshot() const;
  [[nodiscard]] std::uint64_t published() const noexcept { return numbers_.last(); }

  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  // AnyType() until the channel gets a type.
  [[nodiscard]] const TypeInfo& type() const noexcept { return *type_.load(std::memory_order_acquire); }
  [[nodiscard]] std::string declared_at() const;
  [[nodiscard]] GraphCore& core() const noexcept { return core_; }

 private:
  PublishStatus Try(const MessageOffer& offer, Reach reach) noexcept;
  PublishStatus TryAs(const MessageOffer& offer, const TypeInfo& type, Reach reach) noexcept;
  PublishStatus TryOneOfSeveral(const MessageOffer& offer, Reach reach) noexcept;
  void AddSecondType(const TypeInfo& other);
  void AddRawForm();
  void AdoptType(const TypeInfo& type, const CallSite& where);
  // Adds a place for the other form if the channel has two types or the message is raw.
  [[nodiscard]] AnyMessage Wrapped(AnyMessage message, const TypeInfo& type);
  [[nodiscard]] const TypeInfo& TypeOfMessage(const AnyMessage& message) const noexcept;
  class Handover;
  void HandOver(Publication& publication, std::int64_t now) noexcept;
  // Delivers the message to all nodes except `except`. `last`: the message is not needed afterwards.
  struct Handing {
    std::size_t bytes = 0;
    bool reserved = false;
    bool last = false;
    const Node* except = nullptr;
    std::int64_t now = 0;
  };
  void Deliver(const Fanout& fanout, AnyMessage& message, const MessageInfo& info,
               const std::shared_ptr<const void>& credit, const Handing& handing) noexcept;
  void Trace(const MessageInfo& info) const noexcept;
  PublishStatus PublishToSole(const Fanout& fanout, const MessageOffer& offer, std::size_t bytes) noexcept;
  // Latches the message and returns the current nodes. Returns null without latching if one of them is inline and user
  // code is refused.
  const Fanout* Store(const AnyMessage& message, MessageInfo& info, std::size_t depth, std::size_t bytes,
                      UserCode user_code);
  // Reserves room in all lossless nodes, or in none of them.
  [[nodiscard]] bool ReserveAll(const Fanout& fanout, std::size_t bytes) noexcept;
  void Replace(std::shared_ptr<const Fanout> fanout);

  const std::string name_;
  std::atomic<const TypeInfo*> type_;  // Replaced, under wiring_mutex_, if it was AnyType() or a run-time type.
  std::string declared_at_;            // Guarded by wiring_mutex_.
  GraphCore& core_;
  std::atomic<const Fanout*> fanout_;
  std::atomic<Outlet*> outlet_{nullptr};
  std::atomic<const TypeInfo*> other_type_{nullptr};  // Set once, under wiring_mutex_.
  RawPresence raw_;                                   // Written under wiring_mutex_.
  // How local messages are wrapped, in bits.
  static constexpr unsigned kSeveralForms = 1;  // Messages are published as other_type_, or raw.
  static constexpr unsigned kSharedRaw = 2;     // Several nodes take them raw, so that they are encoded once for all.
  std::atomic<unsigned> wrapping_{0};           // Written under wiring_mutex_.
  std::atomic<bool> closed_{false};
  std::atomic<std::size_t> latched_{0};
  alignas(64) MessageNumbers numbers_;
  PublishRate rate_;  // In the same line of the cache.

  alignas(64) mutable std::mutex wiring_mutex_;
  std::shared_ptr<const Fanout> current_fanout_;
  std::shared_ptr<Outlet> current_outlet_;
  std::atomic<std::size_t> next_node_number_{0};
  // Held while nodes get what a publisher that is back has latched, so that they get its next message later.
  std::recursive_mutex returns_mutex_;
  std::mutex latch_mutex_;
  LatchedMessages latched_messages_;
  bool returns_ = false;  // Nodes get them now; guarded by latch_mutex_.
  RawForms raw_forms_;
  RoomSignal room_;
  ChannelCounts counts_;
};

}  // namespace hgros
