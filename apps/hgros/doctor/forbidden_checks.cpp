// Channels whose messages are kept from their subscribers: forbidden ones, lists of endpoints, closed channels.
#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "doctor/evidence.hpp"

namespace hgros::cli {
namespace {

// A word of a command for the shell: channels and sessions may have any names.
std::string ShellWord(const std::string& name) {
  constexpr std::string_view kPlain = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_./:-";
  if (!name.empty() && name.find_first_not_of(kPlain) == std::string::npos) return name;
  std::string quoted = "'";
  for (const char one : name) quoted += one == '\'' ? std::string("'\\''") : std::string(1, one);
  return quoted + "'";
}

enum class Direction { kOut, kIn };

std::string ReasonOf(const Snapshot::Channel& channel, Direction way) {
  return way == Direction::kOut ? channel.not_leaving() : channel.not_entering();
}

// The sessions at the other end: those that are known, and those that keep the channel from themselves, which do not
// announce it.
std::set<SessionId> OtherEnds(const Evidence& evidence, const std::string& name, SessionId session, Direction way) {
  std::set<SessionId> others;
  const auto channel = std::ranges::find(evidence.channels, name, &KnownChannel::name);
  if (channel != evidence.channels.end()) {
    for (const ChannelUser& user : way == Direction::kOut ? channel->subscribers : channel->publishers) {
      others.insert(user.session);
    }
  }
  for (const auto& [other, snapshot] : evidence.after) {
    const Snapshot::Channel* one = CountersOf(evidence.after, other, name);
    if (one != nullptr && !ReasonOf(*one, way == Direction::kOut ? Direction::kIn : Direction::kOut).empty())
      others.insert(other);
  }
  others.erase(session);
  return others;
}

void CheckDirection(const Evidence& evidence, SessionId session, const Snapshot::Channel& channel, Direction way,
                    std::set<std::pair<std::string, SessionId>>& said, Findings& findings) {
  const std::string why = ReasonOf(channel, way);
  if (why.empty()) return;
  const bool forbidden = channel.forbidden();
  std::string others;
  for (const SessionId other : OtherEnds(evidence, channel.name(), session, way)) {
    const bool out = way == Direction::kOut;
    const auto known = WayBetween(evidence.after, out ? session : other, out ? other : session);
    if (!forbidden && known.transport == "shared memory") continue;  // The lists of endpoints do not matter there.
    others += (others.empty() ? "" : ", ") + evidence.NameOf(other);
  }
  if (others.empty() || !said.emplace(channel.name(), session).second) return;
  const std::string name = evidence.NameOf(session);
  findings.push_back(
      {Severity::kFault, "forbidden",
       fmt::format("{} {} \"{}\", {} {} {}, but no message passes. {}{}", name,
                   way == Direction::kOut ? "publishes" : "subscribes to", channel.name(),
                   way == Direction::kOut ? "to which" : "which", others,
                   way == Direction::kOut ? "subscribes" : "publishes", forbidden ? "In " + name + ": " : "", why),
       fmt::format("{}hgros control allow {} --session {}",
                   forbidden ? "" : "Add it to `channels` of an endpoint in the YAML of " + name + ", or for now: ",
                   ShellWord(channel.name()), ShellWord(name))});
}

// A closed channel is right if its nodes hear another session instead.
void CheckClosed(const Evidence& evidence, SessionId session, const Snapshot::Channel& channel, Findings& findings) {
  if (!channel.closed() || channel.nodes().empty()) return;
  const auto grows = [&](auto counter) { return evidence.GrowthOf(session, channel.name(), counter) > 0; };
  if (!grows(&Snapshot::Channel::published) || grows(&Snapshot::Channel::received)) return;
  const std::string name = evidence.NameOf(session);
  findings.push_back({Severity::kFault, "forbidden",
                      fmt::format("{} publishes \"{}\" and subscribes to it itself, but the channel is closed there: "
                                  "its {} gets nothing.",
                                  name, channel.name(), channel.nodes(0).name()),
                      fmt::format("Remove it from `data_graph: close_channels` in the YAML of {}, or for now: hgros "
                                  "control open {} --session {}",
                                  name, ShellWord(channel.name()), ShellWord(name))});
}

}  // namespace

void CheckForbidden(const Evidence& evidence, Findings& findings) {
  std::set<std::pair<std::string, SessionId>> said;
  for (const auto& [session, snapshot] : evidence.after) {
    for (const Snapshot::Channel& channel : snapshot->channels()) {
      CheckDirection(evidence, session, channel, Direction::kOut, said, findings);
      CheckDirection(evidence, session, channel, Direction::kIn, said, findings);
      CheckClosed(evidence, session, channel, findings);
    }
  }
}

bool IsKeptFromOthers(const Evidence& evidence, const std::string& channel) {
  return std::ranges::any_of(evidence.after, [&](const auto& one) {
    const Snapshot::Channel* counters = CountersOf(evidence.after, one.first, channel);
    return counters != nullptr && !(counters->not_leaving().empty() && counters->not_entering().empty());
  });
}

}  // namespace hgros::cli
