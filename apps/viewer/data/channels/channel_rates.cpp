#include "viewer/data/channels/channel_rates.hpp"

#include <algorithm>
#include <cmath>

namespace hgros::viewer {

void ChannelRate::Add(const MessageInfo& info, std::size_t bytes, std::int64_t monotonic_ns, std::int64_t wall_ns) {
  ++messages_;
  bytes_ += bytes;
  if (info.id.publisher != 0 && (senders_.size() < kMaxSenders || senders_.contains(info.id.publisher))) {
    Sender& sender = senders_[info.id.publisher];
    if (sender.incarnation == info.id.incarnation && info.id.sequence > sender.sequence + 1) {
      missed_ += info.id.sequence - sender.sequence - 1;
    }
    if (info.id.sequence > sender.sequence || sender.incarnation != info.id.incarnation) {
      sender = {info.id.incarnation, info.id.sequence};
    }
  }
  std::optional<std::int64_t> latency;
  if (!info.remote) {
    latency = monotonic_ns - info.publish_monotonic_ns;
  } else if (info.publish_time_ns != 0) {
    latency = wall_ns - info.publish_time_ns;
  }
  arrivals_.push_back({monotonic_ns, bytes, latency});
  while (arrivals_.size() > kMaxArrivals || monotonic_ns - arrivals_.front().at_ns > kWindow.count()) {
    arrivals_.pop_front();
  }
}

ChannelRate::Figures ChannelRate::At(std::int64_t monotonic_ns) const {
  Figures figures;
  figures.messages = messages_;
  figures.bytes = bytes_;
  figures.missed = missed_;
  if (!arrivals_.empty()) figures.silence = std::chrono::nanoseconds(monotonic_ns - arrivals_.back().at_ns);
  double bytes = 0, latencies = 0, steps = 0, squares = 0;
  std::size_t count = 0, told = 0;
  const Arrival* first = nullptr;
  const Arrival* before = nullptr;
  for (const Arrival& arrival : arrivals_) {
    if (monotonic_ns - arrival.at_ns > kWindow.count()) continue;
    if (first == nullptr) first = &arrival;
    if (before != nullptr) {
      const auto step = static_cast<double>(arrival.at_ns - before->at_ns);
      steps += step;
      squares += step * step;
      bytes += static_cast<double>(arrival.bytes);
    }
    before = &arrival;
    ++count;
    if (arrival.latency_ns) {
      latencies += static_cast<double>(*arrival.latency_ns);
      ++told;
    }
  }
  if (told > 0) figures.latency = std::chrono::nanoseconds(std::llround(latencies / static_cast<double>(told)));
  if (count < 2) return figures;
  // If the next message is overdue, the time until now counts: the rate of a channel that has stopped goes down.
  const double gaps = static_cast<double>(count - 1);
  const double span = std::max(steps, static_cast<double>(monotonic_ns - first->at_ns) - steps / gaps);
  if (span <= 0) return figures;
  figures.messages_per_second = gaps / span * 1e9;
  figures.bytes_per_second = bytes / span * 1e9;
  if (count > 2) {
    const double mean = steps / gaps;
    figures.jitter = std::chrono::nanoseconds(std::llround(std::sqrt(std::max(0.0, squares / gaps - mean * mean))));
  }
  return figures;
}

}  // namespace hgros::viewer
