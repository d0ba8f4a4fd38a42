#include "transport/peer_channel.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace hgros {
namespace {

constexpr std::uint32_t kMaxDepth = 1u << 20;
constexpr std::uint32_t kMaxCreditMessages = 1u << 16;
constexpr std::uint32_t kDepthBeforeBegin = 64;

}  // namespace

PeerChannel::PeerChannel(const Demand& granted) : demand_(granted) {}

Demand PeerChannel::Granted(const Demand& asked, std::uint64_t max_credit_bytes) noexcept {
  return {
      .lossless = asked.lossless,
      .queue_depth = std::clamp(asked.queue_depth, 1u, kMaxDepth),
      .credit_messages = std::clamp(asked.credit_messages, 1u, kMaxCreditMessages),
      .credit_bytes = std::clamp<std::uint64_t>(asked.credit_bytes, 1, std::max<std::uint64_t>(max_credit_bytes, 1))};
}

// When a link becomes lossless, earlier messages cannot be sent again: only messages from now on are promised.
std::size_t PeerChannel::SetDemand(const Demand& granted, Dropped& dropped) {
  if (demand_.lossless && !granted.lossless) {
    std::ranges::move(unconfirmed_, std::back_inserter(dropped));
    unconfirmed_.clear();
    reserved_ = 0;
  }
  demand_ = granted;
  return Trim(~std::uint64_t{0}, dropped);
}

bool PeerChannel::HasCredit() const noexcept {
  return sent_messages_ - confirmed_messages_ < demand_.credit_messages &&
         sent_bytes_ - confirmed_bytes_ < demand_.credit_bytes;
}

bool PeerChannel::HasRoom() const noexcept {
  const std::uint64_t live = ring_.size() - latched_waiting_;
  return sent_messages_ - confirmed_messages_ + live + reserved_ < demand_.credit_messages &&
         sent_bytes_ - confirmed_bytes_ + waiting_bytes_ < demand_.credit_bytes;
}

bool PeerChannel::HoldsUp(bool waits, std::chrono::steady_clock::time_point now) noexcept {
  if (!waits || !lossless() || HasRoom()) {
    full_since_.reset();
    return false;
  }
  if (!full_since_ || confirmed_when_full_ != confirmed_messages_) {
    full_since_ = now;
    confirmed_when_full_ = confirmed_messages_;
  }
  if (now - *full_since_ < kHoldsUpAfter) return false;
  full_since_ = std::chrono::steady_clock::time_point::max();
  return true;
}

bool PeerChannel::IsLatched(const MessageId& id) const {
  if (id.publisher == 0 || id.sequence == 0) return false;
  const auto last = last_latched_.find(id.publisher);
  return last != last_latched_.end() && last->second.incarnation == id.incarnation &&
         id.sequence <= last->second.sequence;
}

bool PeerChannel::Push(PendingMessage message) {
  CancelReservation();
  if (IsLatched(message.id)) return false;
  const std::uint64_t bytes = message.bytes;
  ring_.push_back(std::move(message));
  waiting_bytes_ += bytes;  // Last, because push_back() may throw.
  return true;
}

std::optional<PendingMessage> PeerChannel::Pop() {
  if (!begun_ || paused_ || ring_.empty() || !HasCredit()) return std::nullopt;
  if (demand_.lossless) unconfirmed_.push_back(ring_.front());  // First, because it may throw.
  PendingMessage message = std::move(ring_.front());
  ring_.pop_front();
  if (latched_waiting_ > 0) --latched_waiting_;
  waiting_bytes_ -= message.bytes;
  ++sent_messages_;
  sent_bytes_ += message.bytes;
  return message;
}

std::size_t PeerChannel::Trim(std::uint64_t spare_bytes, Dropped& dropped) {
  if (demand_.lossless) return 0;
  // A subscriber counts from the moment its link is made. Messages published before the link begins must not be
  // lost.
  const std::size_t depth = begun_ ? demand_.queue_depth : std::max(demand_.queue_depth, kDepthBeforeBegin);
  std::size_t count = 0;
  std::uint64_t freed = 0;
  const std::uint64_t excess = waiting_bytes_ > spare_bytes ? waiting_bytes_ - spare_bytes : 0;
  while (ring_.size() - latched_waiting_ > depth || (freed < excess && ring_.size() - latched_waiting_ > 1)) {
    const auto oldest = ring_.begin() + static_cast<std::ptrdiff_t>(latched_waiting_);
    freed += oldest->bytes;
    waiting_bytes_ -= oldest->bytes;
    dropped.push_back(std::move(*oldest));
    ring_.erase(oldest);
    ++count;
  }
  return count;
}

// The ring holds all messages since the link was made, in order. Latched messages are only needed for the time
// before.
void PeerChannel::Begin(std::vector<PendingMessage> latched) {
  if (!ring_.empty()) {
    const MessageId first = ring_.front().id;
    std::erase_if(latched, [&first](const PendingMessage& one) {
      return one.id.publisher == first.publisher && one.id.incarnation == first.incarnation &&
             one.id.sequence >= first.sequence;
    });
  }
  for (const auto& message : latched) {
    auto& last = last_latched_[message.id.publisher];
    if (std::pair(message.id.incarnation, message.id.sequence) > std::pair(last.incarnation, last.sequence)) {
      last = message.id;
    }
  }
  latched_waiting_ = latched.size();
  ring_.insert(ring_.begin(), std::make_move_iterator(latched.begin()), std::make_move_iterator(latched.end()));
  waiting_bytes_ = 0;
  for (const auto& message : ring_) waiting_bytes_ += message.bytes;
  begun_ = true;
}

bool PeerChannel::Confirm(std::uint64_t messages, std::uint64_t bytes, Dropped& dropped) {
  if (messages > sent_messages_ || bytes > sent_bytes_) return false;
  if (messages < confirmed_messages_ || bytes < confirmed_bytes_) return true;  // An older confirmation.
  while (unconfirmed_.size() > sent_messages_ - messages) {
    dropped.push_back(std::move(unconfirmed_.front()));
    unconfirmed_.pop_front();
  }
  confirmed_messages_ = messages;
  confirmed_bytes_ = bytes;
  return true;
}

std::vector<PendingMessage> PeerChannel::Unfinished() const {
  std::vector<PendingMessage> all(unconfirmed_.begin(), unconfirmed_.end());
  all.insert(all.end(), ring_.begin(), ring_.end());
  return all;
}

std::optional<std::uint64_t> PeerChannel::Resume(std::uint64_t received_messages, std::uint64_t received_bytes) {
  if (received_messages < confirmed_messages_ || received_messages > sent_messages_) return std::nullopt;
  if (received_bytes < confirmed_bytes_ || received_bytes > sent_bytes_) return std::nullopt;
  std::uint64_t lost = sent_messages_ - received_messages;
  while (demand_.lossless && lost > 0 && !unconfirmed_.empty()) {
    const std::uint64_t bytes = unconfirmed_.back().bytes;
    ring_.push_front(std::move(unconfirmed_.back()));
    waiting_bytes_ += bytes;
    unconfirmed_.pop_back();
    --lost;
  }
  sent_messages_ = received_messages;
  sent_bytes_ = received_bytes;
  paused_ = false;
  return lost;
}

}  // namespace hgros
