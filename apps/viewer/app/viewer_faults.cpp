#include <algorithm>
#include <cstdint>
#include <utility>

#include "viewer/app/viewer.hpp"

namespace hgros::viewer {

void Viewer::CountUnreadable(double now_s) {
  constexpr double kPeriodS = 2;
  if (now_s < next_count_s_) return;
  const bool shown = std::ranges::any_of(channels_, [](const ChannelRow& row) { return !row.schema.empty(); });
  next_count_s_ = shown ? now_s + kPeriodS : kNever;
  if (!shown) return;
  const SessionSnapshot own = session_.Snapshot();
  for (Scene::Entry& entry : scene_.entries()) {
    if (entry.channel.empty()) continue;
    std::uint64_t count = 0;
    const auto traffic = std::ranges::find(own.traffic, entry.channel, &ChannelTraffic::channel);
    if (traffic != own.traffic.end()) count += traffic->faults[static_cast<std::size_t>(PacketFault::kData)];
    // While a panel takes the bytes as they come, they are read behind that.
    const auto channel = std::ranges::find(own.graph.channels, entry.channel, &ChannelSnapshot::name);
    if (channel != own.graph.channels.end()) count += channel->not_converted;
    const bool more = count > entry.unreadable;
    if (more != std::exchange(entry.still_unreadable, more) || more) frames_wanted_ = std::max(frames_wanted_, 1);
    entry.unreadable = count;
  }
}

}  // namespace hgros::viewer
