#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <shared_mutex>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/log.hpp"
#include "hgros/bridge/channel_traffic.hpp"
#include "hgros/bridge/outlet_latch.hpp"
#include "hgros/clock/host_clocks.hpp"
#include "hgros/graph/session_outlet.hpp"
#include "hgros/transport/transport.hpp"

namespace hgros {

class JoinedOutbound;
class NetworkBridge;

// Sends one channel to other sessions: numbers and encodes each message once, and passes it to the transports.
//
// Thread safety: all functions from any thread.
// Invariants: order_mutex_ guards the transport, which so gets the messages in the order of their sequence numbers.
// Messages that the transport releases meanwhile are destroyed after the lock. The transport may request the latched
// messages while it holds locks that its Commit() takes, too. So Latched() takes only the latch's mutex, and the
// transport is never called under that. The request comes on a thread of the transport, where no user code may run. So
// from Join() on, messages with a user's codec are encoded when they are latched.
class ChannelOutlet final : public SessionOutlet, public OutboundSource {
 public:
  ChannelOutlet(std::string channel, const TypeInfo& type, MessageId publisher, std::shared_ptr<Log> log,
                OutletEvents events, std::shared_ptr<const HostClocks> clocks);

  void Join(NetworkBridge& bridge);
  // Leaves the transport. Later publishes stay inside the process.
  void Detach();
  // If `stays`, later publishes stay inside the process. Those that were accepted still leave until Detach().
  void SetStays(bool stays);
  // Whether accepted messages have not left, or lossless subscribers have not consumed them.
  [[nodiscard]] bool HasUnfinished() const;
  // If accepted messages have not left: how many lossless subscribers have not consumed. Otherwise 0.
  [[nodiscard]] std::size_t Unsent() const;
  void Latch(std::size_t count) {
    if (count > latched_.load(std::memory_order_relaxed)) latched_.store(count, std::memory_order_relaxed);
  }
  // For a component that moves: a message that it has published in another place. Subscribers that come later get it;
  // the others have got it from there. False: the channel is not latched here.
  bool KeepLatched(AnyMessage message, Payload data, std::int64_t publish_time_ns);
  void ForgetLatched();
  // From Join() on, subscribers that ask for lossless delivery are keep-last.
  void PromiseNothing() noexcept { may_promise_ = false; }
  // Memory in which a message can be published without a copy, if a transport with subscribers has some.
  [[nodiscard]] std::optional<Block> Loan(std::size_t size_bytes);

  [[nodiscard]] bool wanted() const noexcept override;
  PublishStatus Reserve(const void* message, const TypeInfo& type, PreparedMessage& prepared) noexcept override;
  bool Commit(const AnyMessage& message, const TypeInfo& type, const MessageInfo& info,
              PreparedMessage&& prepared) noexcept override;
  void Cancel() noexcept override;

  std::vector<OutboundMessage> Latched(SessionId /*subscriber*/) noexcept override;
  [[nodiscard]] bool may_promise() const noexcept override { return may_promise_; }
  void OnRoom() noexcept override { events_.on_room(); }
  void OnSubscribers(std::size_t count) noexcept override;
  void OnUnsubscribed(SessionId subscriber) noexcept override {
    if (events_.on_unsubscribed) events_.on_unsubscribed(subscriber);
  }

  [[nodiscard]] const std::string& channel() const noexcept { return channel_; }
  [[nodiscard]] const TypeInfo& type() const noexcept { return type_; }
  [[nodiscard]] std::size_t subscriber_count() const noexcept override {
    return subscribers_.load(std::memory_order_acquire);
  }
  [[nodiscard]] std::vector<SessionId> Subscribers() const override;
  void AddTo(ChannelTraffic& traffic) const;

 private:
  // True for a user's codec, which must not run on the thread on which a transport requests latched messages.
  [[nodiscard]] bool WritesWhenLatched(const TypeInfo& type) const noexcept {
    return type.users_codec && joined_.load(std::memory_order_relaxed);
  }
  // Takes memory, of one of the transports if possible, or encodes the message if its size is known only then.
  // With a size, under transports_mutex_. Not under order_mutex_: all this takes time. Throws std::bad_alloc.
  [[nodiscard]] PublishStatus Prepare(const void* message, const TypeInfo& type, std::optional<std::size_t> size_bytes,
                                      bool listened, PreparedMessage& prepared);
  // A payload without an owner if the message cannot be written; this is counted and logged.
  // `lend`: whether a transport may be asked for memory. Not under a lock.
  enum class Lend { kNo, kYes };
  [[nodiscard]] Payload Encode(const AnyMessage& message, const TypeInfo& type, PreparedMessage&& prepared,
                               Lend lend = Lend::kNo) noexcept;
  [[nodiscard]] Payload TryEncode(const AnyMessage& message, const TypeInfo& type, PreparedMessage&& prepared,
                                  Lend lend);
  // Logs the sentence "A message on channel ...", in which `why` returns the middle.
  template <typename Why>
  void CountNotEncodable(const Why& why) noexcept;
  [[nodiscard]] PublishStatus RefuseForMemory() noexcept;
  // As Commit(). Throws before it calls the transports.
  [[nodiscard]] bool TryCommit(const AnyMessage& message, const TypeInfo& type, const MessageInfo& info,
                               PreparedMessage&& prepared);
  [[nodiscard]] std::vector<OutboundMessage> TryLatched();
  void SendKept();
  void Number(PacketHead& head, std::uint64_t own_number) noexcept;
  // Under both mutexes.
  void AddPast(const JoinedOutbound& left);
  void CancelPromise() noexcept;
  [[nodiscard]] PacketHead NewHead(std::size_t depth, std::int64_t publish_time_ns) const;

  const std::string channel_;
  // The type of the first user. A message may be raw, or of another C++ type with the same wire form.
  const TypeInfo& type_;
  const MessageId publisher_;
  const std::shared_ptr<Log> log_;
  const OutletEvents events_;
  const std::shared_ptr<const HostClocks> clocks_;

  bool may_promise_ = true;  // Constant from Join() on.
  std::atomic<std::size_t> subscribers_{0};
  // True once there was a subscriber. From then on messages are numbered even during a cut, so that lost ones count.
  std::atomic<bool> heard_{false};
  mutable std::atomic<bool> published_{false};
  std::atomic<std::size_t> latched_{0};
  std::atomic<bool> joined_{false};  // A transport may request latched messages. Set under order_mutex_.
  std::atomic<std::uint64_t> not_encodable_{0};
  std::atomic<std::uint64_t> copied_{0};
  std::atomic<std::uint64_t> loans_{0};
  std::atomic<std::uint64_t> heap_loans_{0};

  std::shared_mutex transports_mutex_;  // Locked before order_mutex_. Shared: transports_ does not change.
  mutable std::mutex order_mutex_;
  // Changed under both mutexes.
  std::shared_ptr<JoinedOutbound> transports_;
  OutboundStats past_;  // Of transports that it has left.
  std::uint64_t sequence_ = 0;
  std::uint64_t taken_over_ = 0;  // Number of messages of KeepLatched().
  bool stays_ = false;            // Under order_mutex_, as the next.
  std::uint64_t promised_ = 0;    // Number of messages between Reserve() and Commit() or Cancel().
  // Each message writes the members above, too, so that these cost no further cache line.
  std::atomic<std::uint64_t> encoded_{0};
  std::atomic<std::uint64_t> encoded_bytes_{0};

  OutletLatch latch_;
};

}  // namespace hgros
