#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "graph/latched_messages.hpp"
#include "graph/node.hpp"
#include "graph/node_stats.hpp"
#include "graph/raw_forms.hpp"
#include "hgros/graph/data_graph.hpp"
#include "hgros/graph/outlet.hpp"
#include "hgros/graph/publisher.hpp"

namespace hgros {

class GraphCore;

// The nodes of a channel at one moment; replaced as a whole, never changed.
struct Fanout {
  std::vector<std::shared_ptr<Node>> nodes;
  bool lossless = false;              // Some node must not lose anything.
  Node* sole_lossless = nullptr;      // That one, if it is the only one.
  bool count_bytes = false;           // Some node has a byte limit.
  bool has_inline = false;            // Some node runs its callback in the delivering thread.
  const TypeInfo* inbound = nullptr;  // As what messages from outside are decoded; null: nobody wants them.
};

// A typed hyperedge.
//
// Thread safety: all public functions may be called from any thread.
// Invariants: fanout_ and outlet_ are read under an epoch guard and replaced under wiring_mutex_. A new node gets a
// latched message exactly once: under latch_mutex_ a publisher stores the message and looks which nodes there are, and
// under the same lock a node is handed what is stored and wired. A message that is not wrapped (two_forms) is of type_;
// a raw one is always wrapped.
class Channel {
 public:
  Channel(std::string name, const TypeInfo& type, std::string declared_at, GraphCore& core);
  Channel(const Channel&) = delete;
  Channel& operator=(const Channel&) = delete;
  ~Channel();

  PublishStatus Publish(const MessageOffer& offer, Reach reach) noexcept;
  PublishStatus PublishWait(const MessageOffer& offer, Reach reach, std::chrono::steady_clock::time_point deadline,
                            const std::stop_token& stop);
  // `type` is one of the channel's.
  [[nodiscard]] bool Inject(AnyMessage message, const TypeInfo& type, const MessageInfo& info,
                            std::shared_ptr<const void> credit, std::size_t latched, UserCode user_code) noexcept;
  [[nodiscard]] const TypeInfo& InboundType() const noexcept;

  // Whether the channel can be used with `type`: its first user's, the second C++ type of the same wire form, or
  // AnyType(). The first question for that second one makes it so; where there was only AnyType() before, the channel
  // gets its type. `where` is where that is asked.
  [[nodiscard]] bool Takes(const TypeInfo& type, const CallSite& where);
  // A message of this channel as `type`, one of those; made at most once for all who ask. Null: it cannot be made.
  [[nodiscard]] AnyMessage InForm(const AnyMessage& message, const TypeInfo& type);

  void Add(const std::shared_ptr<Node>& node);
  void Remove(const Node& node);
  void SetOutlet(std::shared_ptr<Outlet> outlet);
  void Latch(std::size_t count);
  // New nodes get nothing that a remote publisher has latched while it is gone, and get it when it is back.
  void PublisherIsGone(std::uint64_t publisher);
  void PublisherIsBack(std::uint64_t publisher);
  void SetClosed(bool closed) noexcept { closed_.store(closed, std::memory_order_relaxed); }
  void NotifyRoom() noexcept;

  [[nodiscard]] std::vector<std::shared_ptr<Node>> Nodes() const;
  [[nodiscard]] std::size_t NextNodeNumber() noexcept { return next_node_number_++; }
  [[nodiscard]] bool HasOutlet() const noexcept { return outlet_.load(std::memory_order_acquire) != nullptr; }
  [[nodiscard]] ThreadUse UseOfThread() const noexcept;
  [[nodiscard]] ChannelSnapshot Snapshot() const;

  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  // AnyType() until somebody says which.
  [[nodiscard]] const TypeInfo& type() const noexcept { return *type_.load(std::memory_order_acquire); }
  [[nodiscard]] std::string declared_at() const;
  [[nodiscard]] GraphCore& core() const noexcept { return core_; }

 private:
  PublishStatus Try(const MessageOffer& offer, Reach reach) noexcept;
  PublishStatus TryAs(const MessageOffer& offer, const TypeInfo& type, Reach reach) noexcept;
  PublishStatus TryOneOfTwo(const MessageOffer& offer, const TypeInfo& other, Reach reach) noexcept;
  void UseWith(const TypeInfo& other);
  void Adopt(const TypeInfo& type, const CallSite& where);
  // With a place for its other form, if the channel is used with two types, or the message is raw.
  [[nodiscard]] AnyMessage Wrapped(AnyMessage message, const TypeInfo& type) const;
  [[nodiscard]] const TypeInfo& TypeOfMessage(const AnyMessage& message) const noexcept;
  PublishStatus WaitForRoom(const MessageOffer& offer, Reach reach, std::chrono::steady_clock::time_point deadline,
                            const std::stop_token& stop);
  // A local message that was taken and numbered, on its way to everybody. The pointers hold as long as the epoch guard.
  struct Publication {
    AnyMessage message;
    const TypeInfo* type;
    MessageInfo info;
    const Fanout* fanout;
    const Fanout* after;  // The nodes that were wired when it was latched.
    Outlet* outlet;       // Null: it does not leave the process.
    std::size_t bytes;
    bool reserved;
    bool local;
  };
  class Handover;
  void HandOver(Publication& publication, std::int64_t now) noexcept;
  // Hands the message to the nodes, but not to `except`. `last`: nobody needs the message afterwards.
  struct Handing {
    std::size_t bytes = 0;
    bool reserved = false;
    bool last = false;
    const Node* except = nullptr;
    std::int64_t now = 0;
  };
  void Deliver(const Fanout& fanout, AnyMessage& message, const MessageInfo& info,
               const std::shared_ptr<const void>& credit, const Handing& handing) noexcept;
  PublishStatus PublishToSole(const Fanout& fanout, const MessageOffer& offer, std::size_t bytes) noexcept;
  // Keeps the message for late nodes; returns the nodes that are wired at this moment, or null (and keeps nothing) if
  // one of them is inline and user code is refused.
  const Fanout* Store(const AnyMessage& message, MessageInfo& info, std::size_t depth, UserCode user_code);
  void DeliverToNewcomers(const Fanout& before, const Fanout& after, AnyMessage& message, const MessageInfo& info,
                          std::size_t bytes) noexcept;
  // Takes room in every lossless node, or in none.
  [[nodiscard]] bool ReserveAll(const Fanout& fanout, std::size_t bytes) noexcept;
  void CancelAll(const Fanout& fanout, std::size_t count, std::size_t bytes) noexcept;
  void Replace(std::shared_ptr<const Fanout> fanout);

  const std::string name_;
  std::atomic<const TypeInfo*> type_;  // Set once more, under wiring_mutex_, if it was AnyType().
  std::string declared_at_;            // Under wiring_mutex_.
  GraphCore& core_;

  std::atomic<const Fanout*> fanout_;
  std::atomic<Outlet*> outlet_{nullptr};
  std::atomic<const TypeInfo*> other_type_{nullptr};  // Set once, under wiring_mutex_.
  std::atomic<bool> raw_{false};                      // Some node takes messages raw, or did.
  std::atomic<bool> closed_{false};
  std::atomic<std::size_t> latched_{0};
  alignas(64) std::atomic<std::uint64_t> sequence_{0};  // Of the last message that this process published.

  alignas(64) mutable std::mutex wiring_mutex_;
  std::shared_ptr<const Fanout> current_fanout_;
  std::shared_ptr<Outlet> current_outlet_;
  std::atomic<std::size_t> next_node_number_{0};

  std::mutex latch_mutex_;
  LatchedMessages latched_messages_;
  RawForms raw_forms_;

  std::mutex room_mutex_;
  std::condition_variable_any room_;
  std::uint64_t room_generation_ = 0;
  alignas(64) std::atomic<int> room_waiters_{0};  // Read for every message that a lossless node runs.

  std::atomic<std::uint64_t> refused_{0};
  std::atomic<std::uint64_t> received_{0};
  std::atomic<std::uint64_t> converted_{0};
  std::atomic<std::uint64_t> not_converted_{0};
};

}  // namespace hgros
