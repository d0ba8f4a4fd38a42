#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "hgros/base/ids.hpp"
#include "hgros/transport/transport.hpp"

namespace hgros {

/// A message that a transport has packed once for all its peers.
class Outgoing {
 public:
  virtual ~Outgoing() = default;
};

/// A message waiting for one peer, or sent and not confirmed.
struct PendingMessage {
  std::shared_ptr<const Outgoing> packed;
  MessageId id;
  std::uint64_t bytes = 0;
};

/// The sending side of one channel toward one peer: a ring of waiting messages, the credit, and for lossless peers
/// the messages that were sent and not confirmed. It knows no socket: its owner sends the messages that Pop()
/// returns.
///
/// Messages are numbered from 1 in the order of Pop(); these are numbers of the link, not of the publisher. All counts
/// are cumulative, so the next confirmation replaces a lost one.
///
/// Thread safety: none; the endpoint's mutex guards it.
/// Invariants: confirmed <= sent; Pop() returns nothing while sent - confirmed has used up the credit, or while the
/// link is paused or has not begun. Lossless: nothing is ever dropped, and the unconfirmed messages are exactly
/// confirmed + 1 ... sent, except those that were sent while the link was keep-last. Keep-last: at most queue_depth
/// live messages wait; until the link begins, at least 64 may.
class PeerChannel {
 public:
  /// Messages that are no longer needed, to be destroyed when no mutex is held: their destructors are the user's code.
  using Dropped = std::vector<PendingMessage>;

  explicit PeerChannel(const Demand& granted);

  /// The demand that a publisher grants to a peer that asks for this one: within limits, and with zeros raised to the
  /// smallest value that works.
  [[nodiscard]] static Demand Granted(const Demand& asked, std::uint64_t max_credit_bytes) noexcept;

  [[nodiscard]] bool lossless() const noexcept { return demand_.lossless; }
  [[nodiscard]] const Demand& demand() const noexcept { return demand_; }
  /// Applies from the next message on. Returns how many waiting messages were dropped because of a smaller depth.
  std::size_t SetDemand(const Demand& granted, Dropped& dropped);

  /// Lossless: whether a message can be promised.
  [[nodiscard]] bool HasRoom() const noexcept;
  /// True once if a publisher has waited for this peer, which has confirmed nothing, for kHoldsUpAfter. To be called
  /// regularly. `waits`: a publisher waits for room in the channel.
  [[nodiscard]] bool HoldsUp(bool waits, std::chrono::steady_clock::time_point now) noexcept;
  static constexpr std::chrono::seconds kHoldsUpAfter{10};
  void Reserve() noexcept { ++reserved_; }
  void CancelReservation() noexcept {
    if (reserved_ > 0) --reserved_;
  }

  /// Adds a committed message, and uses up its reservation if it has one. False if the message is skipped because it
  /// was already sent as a latched one; then the reservation is only returned.
  bool Push(PendingMessage message);
  /// Returns the next message that may be sent now, and counts it as sent; its number on the link is sent(). None:
  /// credit is used up, or nothing waits.
  [[nodiscard]] std::optional<PendingMessage> Pop();
  /// Keep-last: drops the oldest live messages beyond the depth, and beyond `spare_bytes` as long as another is left.
  /// Returns how many. Call it when Pop() gives no more.
  std::size_t Trim(std::uint64_t spare_bytes, Dropped& dropped);

  /// Begins the link. The latched messages go first, except those that already wait as live ones. Live messages that
  /// come later and were among the latched ones are skipped.
  void Begin(std::vector<PendingMessage> latched);

  /// Sets the total that the peer has consumed. A smaller total than before changes nothing. False if it is more than
  /// was sent; then nothing changes either.
  bool Confirm(std::uint64_t messages, std::uint64_t bytes, Dropped& dropped);

  /// Sends nothing until Resume(); commits wait in the ring.
  void Pause() noexcept { paused_ = true; }
  [[nodiscard]] bool paused() const noexcept { return paused_; }
  /// Continues after a cut. The peer has received this much in total; a lossless link sends the rest again. Returns
  /// how many messages are lost for good (keep-last), or nullopt if the peer's counts are impossible.
  [[nodiscard]] std::optional<std::uint64_t> Resume(std::uint64_t received_messages, std::uint64_t received_bytes);

  [[nodiscard]] std::uint64_t sent() const noexcept { return sent_messages_; }
  [[nodiscard]] std::uint64_t confirmed() const noexcept { return confirmed_messages_; }
  [[nodiscard]] std::uint64_t unconfirmed() const noexcept { return sent_messages_ - confirmed_messages_; }
  [[nodiscard]] std::uint64_t waiting_bytes() const noexcept { return waiting_bytes_; }
  /// Also those that a paused lossless link will send again.
  [[nodiscard]] std::uint64_t unsent_bytes() const noexcept {
    return waiting_bytes_ + (paused_ && demand_.lossless ? sent_bytes_ - confirmed_bytes_ : 0);
  }
  [[nodiscard]] std::size_t waiting() const noexcept { return ring_.size(); }
  /// Number of messages that a lossless peer would miss if it died now.
  [[nodiscard]] std::size_t unfinished() const noexcept { return unconfirmed_.size() + ring_.size(); }
  /// Those messages, oldest first.
  [[nodiscard]] std::vector<PendingMessage> Unfinished() const;

 private:
  [[nodiscard]] bool HasCredit() const noexcept;
  [[nodiscard]] bool IsLatched(const MessageId& id) const;

  Demand demand_;
  bool begun_ = false;
  bool paused_ = false;
  std::deque<PendingMessage> ring_;
  std::size_t latched_waiting_ = 0;  // Latched messages at the front of ring_: the depth does not apply to them.
  std::uint64_t waiting_bytes_ = 0;
  std::deque<PendingMessage> unconfirmed_;
  std::uint64_t reserved_ = 0;
  std::uint64_t sent_messages_ = 0;
  std::uint64_t sent_bytes_ = 0;
  std::uint64_t confirmed_messages_ = 0;
  std::uint64_t confirmed_bytes_ = 0;
  // Since when it has no room and these are confirmed; none: it has room. At the end of time: that was said.
  std::optional<std::chrono::steady_clock::time_point> full_since_;
  std::uint64_t confirmed_when_full_ = 0;
  std::unordered_map<std::uint64_t, MessageId> last_latched_;  // By publisher.
};

}  // namespace hgros
