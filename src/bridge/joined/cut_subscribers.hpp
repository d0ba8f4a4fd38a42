#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <vector>

#include "hgros/transport/transport.hpp"

namespace hgros {

/// Lossless subscribers of one channel that a transport has lost and that may come back, over that transport or
/// another one. Keeps the messages that each has not confirmed, and those that are published until it is back.
///
/// Thread safety: all functions. Invariants: each keeps about as many messages as its credit allows. Messages that
/// were promised before the cut, and those of publishers that checked HasRoom() at the same time, come in addition.
class CutSubscribers {
 public:
  using Messages = std::vector<OutboundMessage>;

  /// `unfinished`: the messages that the subscriber must get first, oldest first. Returns the number of this cut, see
  /// Drop().
  std::uint64_t Add(SessionId subscriber, const Demand& demand, Messages&& unfinished);
  /// Cheap while no subscriber is cut off.
  [[nodiscard]] std::size_t count() const noexcept { return count_.load(std::memory_order_acquire); }
  /// Whether one more message can be kept for each cut subscriber.
  [[nodiscard]] bool HasRoom() const;
  /// Returns the number of subscribers for which there was no memory to keep it.
  std::size_t Push(const PacketHead& head, const Payload& data) noexcept;
  /// The subscriber is back. Returns the messages that it must get first, oldest first, and keeps none of them.
  [[nodiscard]] Messages TakeMessages(SessionId subscriber);
  /// It does not come back. Returns the messages that it misses; the caller counts and destroys them. Returns nothing
  /// if it is not cut off, or if `cut` is the number of an earlier cut.
  [[nodiscard]] std::optional<Messages> Drop(SessionId subscriber, std::optional<std::uint64_t> cut = std::nullopt);

 private:
  struct Cut {
    std::uint64_t number = 0;
    Demand demand;
    std::map<std::uint64_t, OutboundMessage> messages;  // By sequence number.
    std::uint64_t bytes = 0;
  };
  static void Keep(Cut& cut, OutboundMessage&& message);

  mutable std::mutex mutex_;
  std::unordered_map<SessionId, Cut> cuts_;
  std::uint64_t last_number_ = 0;
  std::atomic<std::size_t> count_{0};
};

}  // namespace hgros
