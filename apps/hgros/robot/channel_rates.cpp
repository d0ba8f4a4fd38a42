#include "robot/channel_rates.hpp"

#include <algorithm>

namespace hgros::cli {
namespace {

constexpr int kMostUnchanged = 3;

}  // namespace

double PublishedRate(double own_hz, std::uint64_t messages, double seconds) {
  if (seconds <= 0) return own_hz;
  const auto count = static_cast<double>(messages);
  return std::clamp(own_hz, std::max(count - 1, 0.0) / seconds, (count + 1) / seconds);
}

void ChannelRates::Take(Known& known, const Snapshot& snapshot, const Snapshot::Channel& channel) {
  const bool first = known.steady_ns == 0 || channel.published() < known.published;
  const double seconds = (static_cast<double>(snapshot.steady_ns()) - static_cast<double>(known.steady_ns)) / 1e9;
  known.rate_hz = PublishedRate(channel.rate_hz(), channel.published() - known.published, first ? 0 : seconds);
  const bool none_new = first || channel.encoded() <= known.encoded;
  known.new_encoded = none_new ? channel.encoded() : channel.encoded() - known.encoded;
  known.new_bytes = none_new ? channel.encoded_bytes() : channel.encoded_bytes() - known.encoded_bytes;
  known.steady_ns = snapshot.steady_ns();
  known.published = channel.published();
  known.encoded = channel.encoded();
  known.encoded_bytes = channel.encoded_bytes();
  known.unchanged = 0;
}

ChannelRate ChannelRates::Next(const AllCounters& counters, const KnownChannel& channel) {
  ChannelRate sum;
  std::uint64_t encoded = 0;
  std::uint64_t bytes = 0;
  for (const ChannelUser& user : channel.publishers) {
    const Snapshot::Channel* now = CountersOf(counters, user.session, channel.name);
    if (now == nullptr) continue;
    Known& known = known_[{user.session, channel.name}];
    const Snapshot& snapshot = *counters.at(user.session);
    if (snapshot.steady_ns() > known.steady_ns) {
      Take(known, snapshot, *now);
    } else if (++known.unchanged > kMostUnchanged) {
      continue;
    }
    ++sum.publishers;
    sum.published += known.published;
    sum.rate_hz += known.rate_hz;
    encoded += known.new_encoded;
    bytes += known.new_bytes;
  }
  if (encoded > 0) sum.mean_bytes = static_cast<double>(bytes) / static_cast<double>(encoded);
  return sum;
}

}  // namespace hgros::cli
