#include "session/misspelled_names.hpp"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <string_view>
#include <utility>

#include "hgros/base/names.hpp"

namespace hgros {
namespace {

constexpr std::string_view kOwnChannels = "hgros/";
constexpr auto kTimeForOthers = std::chrono::seconds(5);
constexpr auto kBetweenLooks = std::chrono::seconds(1);
constexpr std::string_view kRequests = "hgros/call/";

using Names = std::set<std::string, std::less<>>;

void Append(std::string& list, const std::string& item) { list += (list.empty() ? "" : ", ") + item; }

std::string Quoted(const std::string& name) { return "\"" + name + "\""; }

// For example "camera1" and "camera2": such names are similar on purpose.
bool DifferInDigitsOnly(const std::string& a, const std::string& b) {
  const auto without_digits = [](std::string text) {
    std::erase_if(text, [](unsigned char c) { return std::isdigit(c) != 0; });
    return text;
  };
  return without_digits(a) == without_digits(b);
}

std::vector<std::string> PartsOf(std::string_view name) {
  std::vector<std::string> parts;
  while (name.starts_with('/')) name.remove_prefix(1);
  for (std::size_t end = name.find('/'); end != std::string_view::npos; end = name.find('/')) {
    parts.emplace_back(name.substr(0, end));
    name.remove_prefix(end + 1);
  }
  parts.emplace_back(name);
  return parts;
}

// Stricter than NearestName(), because long names of different channels have much in common: at most one part between
// slashes may differ, and it must be similar. A slash at the beginning does not count.
bool AreProbablyOne(const std::string& a, const std::string& b) {
  const std::vector<std::string> left = PartsOf(a);
  const std::vector<std::string> right = PartsOf(b);
  if (left.size() != right.size()) return false;
  const auto [first, other] = std::ranges::mismatch(left, right);
  if (first == left.end()) return true;
  if (!std::equal(first + 1, left.end(), other + 1)) return false;
  return !DifferInDigitsOnly(*first, *other) && !NearestName(*first, {&*other, 1}).empty();
}

// The most similar name of `used` that the configuration does not have in the same place.
std::string NearestUnlisted(const std::string& name, const Names& used, const Names& listed) {
  std::vector<std::string> candidates;
  std::ranges::copy_if(used, std::back_inserter(candidates), [&](const auto& one) { return !listed.contains(one); });
  return NearestName(name, candidates);
}

// Without a similar name, an entry may well be meant for later or for another process, so nothing is said about it.
void AddMisspelled(const Names& listed, const std::string& where, const Names& all, const Names& used,
                   std::string& list) {
  for (const std::string& name : listed) {
    if (all.contains(name) || name.starts_with(kOwnChannels)) continue;
    const std::string nearest = NearestUnlisted(name, used, listed);
    if (nearest.empty() || !AreProbablyOne(name, nearest)) continue;
    Append(list, Quoted(name) + " in " + where + " (did you mean " + Quoted(nearest) + "?)");
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
  {
    const std::scoped_lock lock(mutex_);
    if (std::exchange(said_unused_, true) || !AreIn(config)) return;
  }
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
  std::string list;
  AddMisspelled(set, "channels", all, all, list);
  AddMisspelled(ListedAt(config.publishers), "network.publisher", all, published, list);
  AddMisspelled(ListedAt(config.subscribers), "network.subscribers", all, subscribed, list);
  AddMisspelled({config.closed_channels.begin(), config.closed_channels.end()}, "data_graph.close_channels", all, all,
                list);
  if (list.empty()) return;
  means_.log->Write(LogLevel::kWarning,
                    "The configuration names channels that this session has not used so far: " + list + ".");
}

void MisspelledNames::Note(const std::string& channel) {
  if (channel.starts_with(kOwnChannels)) return;
  {
    const std::scoped_lock lock(mutex_);
    if (!noted_.insert(channel).second) return;
    due_.emplace_back(std::chrono::steady_clock::now() + kTimeForOthers, channel);
    if (std::exchange(looks_, true)) return;
  }
  LookIn(kTimeForOthers);
}

void MisspelledNames::LookIn(std::chrono::nanoseconds delay) {
  means_.later(delay, [this] {
    if (const auto again = LookForOtherEnds()) LookIn(*again);
  });
}

// Listing all channels takes long, so it is done once for all that are due.
std::optional<std::chrono::nanoseconds> MisspelledNames::LookForOtherEnds() {
  std::vector<std::string> alone;
  std::optional<std::chrono::nanoseconds> again;
  {
    const std::scoped_lock lock(mutex_);
    const auto now = std::chrono::steady_clock::now();
    for (; !due_.empty() && due_.front().first <= now; due_.pop_front()) alone.push_back(due_.front().second);
    looks_ = !due_.empty();
    if (looks_) again = std::max<std::chrono::nanoseconds>(due_.front().first - now, kBetweenLooks);
  }
  std::erase_if(alone, [this](const std::string& channel) { return means_.connected(channel); });
  if (alone.empty()) return again;
  const std::vector<KnownChannel> known = means_.known();
  const SessionId self = means_.own().session.id;
  for (const std::string& channel : alone) SayIfAlone(channel, known, self);
  return again;
}

bool MisspelledNames::HasSubscribers(const KnownChannel& channel) const {
  return !channel.subscribers.empty() || means_.graph.NodeCount(channel.name) > 0;
}

// Says something only if both channels have one end each: then they are probably meant to be one.
void MisspelledNames::SayIfAlone(const std::string& channel, const std::vector<KnownChannel>& known,
                                 SessionId self) const {
  const auto own = std::ranges::find(known, channel, &KnownChannel::name);
  if (own == known.end()) return;
  const auto is_here = [self](const ChannelUser& user) { return user.session == self; };
  const bool awaits = own->publishers.empty() && std::ranges::any_of(own->subscribers, is_here);
  const bool calls = !HasSubscribers(*own) && std::ranges::any_of(own->publishers, is_here);
  if (!awaits && !calls) return;
  std::vector<std::string> others;
  for (const KnownChannel& one : known) {
    const bool fits =
        awaits ? !one.publishers.empty() && !HasSubscribers(one) : !one.subscribers.empty() && one.publishers.empty();
    if (fits && !one.name.starts_with(kOwnChannels) && AreProbablyOne(one.name, channel)) others.push_back(one.name);
  }
  if (others.empty()) return;
  std::string nearest = NearestName(channel, others);
  if (nearest.empty()) nearest = others.front();
  const KnownChannel& other = *std::ranges::find(known, nearest, &KnownChannel::name);
  const ChannelUser& user = (awaits ? other.publishers : other.subscribers).front();
  means_.log->Write(LogLevel::kWarning, Quoted(channel) +
                                            (awaits ? " is subscribed to here, but nobody publishes it. "
                                                    : " is published here, but nobody subscribes to it. ") +
                                            "Did you mean " + Quoted(nearest) + ", which " + user.process +
                                            " (process " + std::to_string(user.pid) + ") " +
                                            (awaits ? "publishes" : "subscribes to") + "?");
}

std::vector<std::string> MisspelledNames::KnownServices() const {
  std::vector<std::string> services;
  for (const KnownChannel& one : means_.known()) {
    if (one.subscribers.empty() || !one.name.starts_with(kRequests)) continue;
    services.push_back(one.name.substr(kRequests.size()));
  }
  return services;
}

}  // namespace hgros
