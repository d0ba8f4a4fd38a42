#include "robot/overview.hpp"

#include <algorithm>
#include <utility>

#include "terminal/json.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {

const Snapshot::Channel* CountersOf(const AllCounters& counters, SessionId session, std::string_view channel) {
  const auto found = counters.find(session);
  return found == counters.end() ? nullptr : CountersIn(found->second.get(), channel);
}

const Snapshot::Channel* CountersIn(const Snapshot* counters, std::string_view channel) {
  if (counters == nullptr) return nullptr;
  const auto& channels = counters->channels();
  const auto one = std::ranges::lower_bound(channels, channel, {}, &Snapshot::Channel::name);
  return one == channels.end() || one->name() != channel ? nullptr : &*one;
}

KnownChannel ChannelNamed(const std::vector<KnownChannel>& channels, const std::string& name) {
  const auto found = std::ranges::find(channels, name, &KnownChannel::name);
  if (found != channels.end()) return *found;
  KnownChannel none;
  none.name = name;
  return none;
}

const Snapshot::Node* FindNode(const Snapshot::Channel* channel, std::string_view name, std::size_t place) {
  if (channel == nullptr) return nullptr;
  for (const Snapshot::Node& node : channel->nodes()) {
    if (node.name() == name && place-- == 0) return &node;
  }
  return nullptr;
}

ChannelTotals TotalsOf(const AllCounters& counters, const KnownChannel& channel) {
  ChannelTotals totals;
  const auto beyond = [](std::uint64_t counted, const std::vector<ChannelUser>& known, const ChannelUser& by) {
    const auto others = static_cast<std::uint64_t>(
        std::ranges::count_if(known, [&](const ChannelUser& other) { return other.session != by.session; }));
    return counted > others ? counted - others : 0;
  };
  for (const ChannelUser& user : channel.publishers) {
    const Snapshot::Channel* one = CountersOf(counters, user.session, channel.name);
    if (one == nullptr) continue;
    totals.known = true;
    totals.published += one->published();
    totals.encoded += one->encoded();
    totals.encoded_bytes += one->encoded_bytes();
    totals.rate_hz += one->rate_hz();
    totals.latched = std::max<std::uint64_t>(totals.latched, one->latched());
    totals.far_subscribers = std::max(totals.far_subscribers, beyond(one->subscribers(), channel.subscribers, user));
  }
  for (const ChannelUser& user : channel.subscribers) {
    const Snapshot::Channel* one = CountersOf(counters, user.session, channel.name);
    if (one == nullptr) continue;
    totals.far_publishers = std::max(totals.far_publishers, beyond(one->publishers(), channel.publishers, user));
    for (const Snapshot::Node& node : one->nodes()) totals.refused += node.refused();
  }
  return totals;
}

Way WayBetween(const AllCounters& counters, SessionId publisher, SessionId subscriber) {
  if (publisher == subscriber) return {"process", ""};
  for (const auto& [from, to] : {std::pair(publisher, subscriber), std::pair(subscriber, publisher)}) {
    const auto found = counters.find(from);
    if (found == counters.end()) continue;
    const auto& peers = found->second->peers();
    const auto peer = std::ranges::find(peers, to.value, &Snapshot::Peer::session);
    if (peer != peers.end()) return {peer->transport(), peer->why()};
  }
  return {};
}

std::vector<std::string> TransportsOf(const AllCounters& counters, const KnownChannel& channel) {
  std::vector<std::string> all;
  for (const ChannelUser& from : channel.publishers) {
    for (const ChannelUser& to : channel.subscribers) {
      std::string transport = WayBetween(counters, from.session, to.session).transport;
      if (!transport.empty() && std::ranges::find(all, transport) == all.end()) all.push_back(std::move(transport));
    }
  }
  std::ranges::sort(all);
  return all;
}

bool IsInternal(std::string_view channel) noexcept {
  return channel.starts_with("hgros/") || channel.starts_with("params/");
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

std::string ShortName(std::string_view process, std::int64_t pid, std::string_view host) {
  return std::string(process) + ":" + std::to_string(pid) + (host.empty() ? "" : "@" + std::string(host));
}

std::string ShortName(const ChannelUser& user, bool with_host) {
  return ShortName(user.process, user.pid, with_host ? user.host : "");
}

ChannelUser UserOf(const Snapshot& counters) {
  ChannelUser user;
  user.session = SessionId{counters.session()};
  user.process = counters.process();
  user.host = counters.host();
  user.pid = counters.pid();
  return user;
}

std::vector<Column> UserColumns(const std::string& heading) {
  return {{"", heading}, {"process", ""}, {"pid", ""}, {"host", ""}, {"session", ""}};
}

std::vector<Cell> UserCells(const ChannelUser& user, bool with_host) {
  return {ShortName(user, with_host), user.process, user.pid, user.host, user.session.ToString()};
}

Cell UserCell(const ChannelUser& user) {
  Json json;
  WriteMembers(json.BeginObject(), UserColumns(""), UserCells(user, false));
  json.EndObject();
  return {JsonText{std::string(json.text())}, Visible(ShortName(user, false))};
}

Cell UserListCell(const std::vector<ChannelUser>& users) {
  Json json;
  json.BeginList();
  std::string shown;
  for (const ChannelUser& user : users) {
    WriteMembers(json.BeginObject(), UserColumns(""), UserCells(user, false));
    json.EndObject();
    shown += (shown.empty() ? "" : ", ") + Visible(ShortName(user, false));
  }
  json.EndList();
  if (users.empty()) return std::vector<std::string>();
  return {JsonText{std::string(json.text())}, std::move(shown)};
}

}  // namespace hgros::cli
