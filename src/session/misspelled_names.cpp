#include "session/misspelled_names.hpp"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <string_view>
#include <utility>

#include "hgros/base/names.hpp"
#include "hgros/base/session_name.hpp"

namespace hgros {
namespace {

constexpr std::string_view kOwnChannels = "hgros/";
constexpr auto kTimeForOthers = std::chrono::seconds(5);
constexpr auto kTimeForLateOnes = std::chrono::seconds(25);  // After kTimeForOthers.
constexpr auto kBetweenLooks = std::chrono::seconds(1);
// Of the channels that are due at once. Each is compared with all; thousands are hardly misspelled.
constexpr std::size_t kMostCompared = 100;

using Names = std::set<std::string, std::less<>>;

std::string Quoted(const std::string& name) { return "\"" + name + "\""; }

// The most similar one of the candidates that are probably the same name. Empty if there is none.
std::string NearestOf(const std::string& name, const std::vector<std::string>& candidates) {
  std::vector<std::string> similar;
  std::ranges::copy_if(candidates, std::back_inserter(similar),
                       [&](const std::string& one) { return DifferByATypingError(one, name); });
  if (similar.empty()) return {};
  std::string nearest = NearestName(name, similar);
  return nearest.empty() ? similar.front() : nearest;
}

// Without a similar name, an entry may well be meant for later or for another process, so nothing is said about it.
void AddMisspelled(const Names& listed, const std::string& where, const Names& all, const Names& used,
                   std::vector<std::string>& found) {
  for (const std::string& name : listed) {
    if (all.contains(name) || name.starts_with(kOwnChannels)) continue;
    std::vector<std::string> unlisted;
    std::ranges::set_difference(used, listed, std::back_inserter(unlisted));
    const std::string nearest = NearestOf(name, unlisted);
    if (nearest.empty()) continue;
    found.push_back(Quoted(name) + " in " + where + " (did you mean " + Quoted(nearest) + "?)");
  }
}

Names ListedAt(const std::vector<EndpointConfig>& endpoints) {
  Names names;
  for (const EndpointConfig& one : endpoints) names.insert(one.channels.begin(), one.channels.end());
  return names;
}

}  // namespace

bool MisspelledNames::AreIn(const Config& config) {
  const auto has_list = [](const EndpointConfig& one) { return !one.channels.empty(); };
  return !config.channels.empty() || !config.closed_channels.empty() ||
         std::ranges::any_of(config.publishers, has_list) || std::ranges::any_of(config.subscribers, has_list);
}

void MisspelledNames::SayUnused(const Config& config) {
  if (!AreIn(config)) return;
  Names all;
  Names published;
  Names subscribed;
  for (const ChannelUse& use : means_.own().channels) {
    all.insert(use.channel);
    if (use.publishes) published.insert(use.channel);
    if (use.subscribes) subscribed.insert(use.channel);
  }
  for (const ChannelSnapshot& channel : means_.graph.Snapshot().channels) all.insert(channel.name);
  Names set;
  for (const auto& [name, settings] : config.channels) set.insert(name);
  std::vector<std::string> found;
  AddMisspelled(set, "channels", all, all, found);
  AddMisspelled(ListedAt(config.publishers), "network.publisher", all, published, found);
  AddMisspelled(ListedAt(config.subscribers), "network.subscribers", all, subscribed, found);
  AddMisspelled({config.closed_channels.begin(), config.closed_channels.end()}, "data_graph.close_channels", all, all,
                found);
  std::string list;
  {
    const std::scoped_lock lock(mutex_);
    for (const std::string& one : found) {
      if (said_.insert(one).second) list += (list.empty() ? "" : ", ") + one;
    }
  }
  if (list.empty()) return;
  means_.log->Write(LogLevel::kWarning,
                    "The configuration names channels that this session has not used so far: " + list + ".");
}

void MisspelledNames::Note(const std::string& channel, Clock::time_point now) {
  if (channel.starts_with(kOwnChannels)) return;
  {
    const std::scoped_lock lock(mutex_);
    if (!noted_.insert(channel).second) return;
    due_.emplace(now + kTimeForOthers, Due{channel});
    if (std::exchange(looks_, true)) return;
  }
  LookIn(kTimeForOthers);
}

void MisspelledNames::LookIn(std::chrono::nanoseconds delay) {
  means_.later(delay, [this] {
    if (const auto again = LookForOtherEnds(Clock::now())) LookIn(*again);
  });
}

// Listing all channels takes long, so it is done only at the second look, and once for all that are due.
std::optional<std::chrono::nanoseconds> MisspelledNames::LookForOtherEnds(Clock::time_point now) {
  std::vector<Due> alone;
  {
    const std::scoped_lock lock(mutex_);
    for (; !due_.empty() && due_.begin()->first <= now; due_.erase(due_.begin())) alone.push_back(due_.begin()->second);
  }
  std::erase_if(alone, [this](const Due& due) { return means_.connected(due.channel); });
  const bool lists = std::ranges::any_of(alone, &Due::again);
  if (lists) {
    const std::vector<KnownChannel> known = means_.known();
    const SessionId self = means_.own().session.id;
    std::size_t compared = 0;
    for (const Due& due : alone) {
      if (due.again && ++compared <= kMostCompared) SayIfAlone(due.channel, known, self);
    }
  }
  const std::scoped_lock lock(mutex_);
  for (const Due& due : alone) {
    if (!due.again) due_.emplace(now + kTimeForLateOnes, Due{due.channel, true});
  }
  looks_ = !due_.empty();
  if (!looks_) return std::nullopt;
  return std::max<std::chrono::nanoseconds>(due_.begin()->first - now, kBetweenLooks);
}

bool MisspelledNames::HasSubscribers(const KnownChannel& channel) const {
  return !channel.subscribers.empty() || means_.graph.NodeCount(channel.name) > 0;
}

bool MisspelledNames::IsPublishedHere(const std::string& channel) const {
  return means_.graph.PublishedCount(channel) > 0;
}

// Says something only if both channels have one end each: then they are probably meant to be one.
void MisspelledNames::SayIfAlone(const std::string& channel, const std::vector<KnownChannel>& known,
                                 SessionId self) const {
  const auto own = std::ranges::find(known, channel, &KnownChannel::name);
  if (own == known.end()) return;
  const auto is_here = [&](const ChannelUser& user) { return user.session == self; };
  const bool awaits =
      own->publishers.empty() && !IsPublishedHere(channel) && std::ranges::any_of(own->subscribers, is_here);
  const bool calls = !HasSubscribers(*own) && std::ranges::any_of(own->publishers, is_here);
  if (!awaits && !calls) return;
  std::vector<std::string> others;
  for (const KnownChannel& one : known) {
    const bool fits =
        awaits ? !one.publishers.empty() && !HasSubscribers(one) : !one.subscribers.empty() && one.publishers.empty();
    if (fits && !one.name.starts_with(kOwnChannels)) others.push_back(one.name);
  }
  const std::string nearest = NearestOf(channel, others);
  if (nearest.empty()) return;
  const KnownChannel& other = *std::ranges::find(known, nearest, &KnownChannel::name);
  const ChannelUser& user = (awaits ? other.publishers : other.subscribers).front();
  means_.log->Write(LogLevel::kWarning, Quoted(channel) +
                                            (awaits ? " is subscribed to here, but nobody publishes it. "
                                                    : " is published here, but nobody subscribes to it. ") +
                                            "Did you mean " + Quoted(nearest) + ", which " +
                                            SessionName(user.process, user.pid, user.host) + " " +
                                            (awaits ? "publishes" : "subscribes to") + "?");
}

}  // namespace hgros
