#include "robot/overview.hpp"

#include <algorithm>

namespace hgros::cli {

const Snapshot::Channel* CountersOf(const AllCounters& counters, SessionId session, std::string_view channel) {
  const auto found = counters.find(session);
  if (found == counters.end()) return nullptr;
  const auto& channels = found->second->channels();
  const auto one = std::ranges::find(channels, channel, &Snapshot::Channel::name);
  return one == channels.end() ? nullptr : &*one;
}

PublishedTotals TotalsOf(const AllCounters& counters, const KnownChannel& channel) {
  PublishedTotals totals;
  for (const ChannelUser& user : channel.publishers) {
    const Snapshot::Channel* one = CountersOf(counters, user.session, channel.name);
    if (one == nullptr) continue;
    totals.known = true;
    totals.published += one->published();
    totals.rate_hz += one->rate_hz();
    totals.latched = std::max<std::uint64_t>(totals.latched, one->latched());
  }
  return totals;
}

std::string_view ServiceOf(std::string_view channel) noexcept {
  constexpr std::string_view kBegin = "hgros/call/";
  return channel.starts_with(kBegin) ? channel.substr(kBegin.size()) : std::string_view();
}

std::string_view ParamsOf(std::string_view channel) noexcept {
  constexpr std::string_view kBegin = "params/";
  constexpr std::string_view kEnd = "/state";
  if (!channel.starts_with(kBegin) || !channel.ends_with(kEnd)) return {};
  return channel.size() <= kBegin.size() + kEnd.size()
             ? std::string_view()
             : channel.substr(kBegin.size(), channel.size() - kBegin.size() - kEnd.size());
}

std::string ShortName(const ChannelUser& user, bool with_host) {
  return user.process + ":" + std::to_string(user.pid) + (with_host ? "@" + user.host : "");
}

}  // namespace hgros::cli
