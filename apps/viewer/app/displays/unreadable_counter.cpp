#include "viewer/app/displays/unreadable_counter.hpp"

#include <cstdint>
#include <utility>

namespace hgros::viewer {
namespace {

std::uint64_t CountUnreadable(const SessionSnapshot& own, const std::string& channel) {
  std::uint64_t count = 0;
  const auto traffic = std::ranges::find(own.traffic, channel, &ChannelTraffic::channel);
  if (traffic != own.traffic.end()) count += traffic->faults[static_cast<std::size_t>(PacketFault::kData)];
  // While a panel takes the channel's bytes as they are, the graph converts them for the display.
  const auto in_graph = std::ranges::find(own.graph.channels, channel, &ChannelSnapshot::name);
  if (in_graph != own.graph.channels.end()) count += in_graph->not_converted;
  return count;
}

}  // namespace

bool UnreadableCounter::Update(double now_s) {
  constexpr double kPeriodS = 2;
  if (now_s < next_s_) return false;
  const bool shown =
      std::ranges::any_of(channels_.published(), [](const ChannelRow& row) { return !row.schema.empty(); });
  next_s_ = shown ? now_s + kPeriodS : std::numeric_limits<double>::infinity();
  if (!shown) return false;
  bool changed = false;
  const SessionSnapshot own = session_.Snapshot();
  for (Scene::Entry& entry : scene_.entries()) {
    if (entry.channel.empty()) continue;
    const std::uint64_t count = CountUnreadable(own, entry.channel);
    const bool more = count > entry.unreadable;
    changed |= more != std::exchange(entry.still_unreadable, more) || more;
    entry.unreadable = count;
  }
  return changed;
}

}  // namespace hgros::viewer
