#pragma once

#include <cstdint>
#include <optional>

#include "hgros/base/ids.hpp"
#include "hgros/bridge/channel_traffic.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/transport/transport.hpp"

namespace hgros {

// What has come from one publisher on one channel: repeats, gaps, and which gaps the end of a link explains.
//
// Thread safety: none.
class PublisherLife {
 public:
  // Messages before one that has arrived.
  struct Gap {
    std::uint64_t messages = 0;
    bool cut = false;  // A link to their sender has ended.
  };

  // Counts a message. False for a repeat. `number` counts the messages that the channel has accepted, in their order.
  // `published_ns` is on the monotonic clock of this process; none if it is not known.
  [[nodiscard]] bool Count(const MessageId& id, std::uint64_t number, std::optional<std::int64_t> published_ns,
                           Gap& lost);
  // A link to the sender has ended, after the channel has accepted so many messages.
  void NoteEnd(OfferEnd why, std::uint64_t accepted);
  // The session does not subscribe for a while.
  void NoteAway() noexcept { away_ = true; }
  // The same, and nothing is kept of what has come: latched messages are new when they come again.
  void StartOver() noexcept { incarnation_ = last_sequence_ = 0; }

  [[nodiscard]] std::int64_t last_heard_ns() const noexcept { return last_heard_ns_; }
  [[nodiscard]] const PublisherTraffic& traffic() const noexcept { return traffic_; }

 private:
  std::uint64_t incarnation_ = 0;
  std::uint64_t last_sequence_ = 0;
  std::int64_t last_heard_ns_ = 0;
  bool away_ = false;
  // When a link to the sender has ended, unless a message that was published later has arrived, or a gap was found.
  std::optional<std::int64_t> cut_ns_;
  OfferEnd cut_why_ = OfferEnd::kLost;
  std::uint64_t cut_after_ = 0;  // The number of the last message that was accepted before.
  PublisherTraffic traffic_;
};

inline bool PublisherLife::Count(const MessageId& id, std::uint64_t number, std::optional<std::int64_t> published_ns,
                                 Gap& lost) {
  last_heard_ns_ = MonotonicNow();
  traffic_.publisher = SessionId{id.publisher};
  if (id.publisher == 0) {  // This publisher does not count its messages, so gaps and repeats cannot be detected.
    ++traffic_.received;
    return true;
  }
  const bool known = incarnation_ == id.incarnation;
  if ((known && id.sequence <= last_sequence_) || id.incarnation < incarnation_) {
    ++traffic_.repeated;
    return false;
  }
  const bool gap = known && id.sequence > last_sequence_ + 1;
  const bool after_cut = cut_ns_ && number > cut_after_;
  // What is accepted after an offer was withdrawn belongs to a later one. The sender may have published it before this
  // session learned of the end, so its time does not tell.
  const bool away = away_ || (after_cut && cut_why_ == OfferEnd::kWithdrawn);
  if (gap && !away) {
    lost = {id.sequence - last_sequence_ - 1, after_cut && cut_why_ == OfferEnd::kLost};
    traffic_.lost += lost.messages;
  }
  if (after_cut && (gap || (published_ns && *published_ns > *cut_ns_))) cut_ns_.reset();
  away_ = false;
  incarnation_ = id.incarnation;
  last_sequence_ = id.sequence;
  ++traffic_.received;
  return true;
}

inline void PublisherLife::NoteEnd(OfferEnd why, std::uint64_t accepted) {
  cut_ns_ = MonotonicNow();
  cut_why_ = why;
  cut_after_ = accepted;
}

}  // namespace hgros
