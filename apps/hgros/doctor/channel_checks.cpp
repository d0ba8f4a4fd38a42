// Types that do not fit, ends that do not meet, and messages that are lost on the way.
#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "doctor/evidence.hpp"
#include "hgros/base/names.hpp"

namespace hgros::cli {
namespace {

std::string Names(const std::vector<ChannelUser>& users) {
  constexpr std::size_t kMost = 3;
  std::string names;
  for (std::size_t i = 0; i < std::min(users.size(), kMost); ++i)
    names += (i == 0 ? "" : ", ") + ShortName(users[i], false);
  return users.size() <= kMost ? names : names + fmt::format(" and {} more", users.size() - kMost);
}

bool IsInternal(const KnownChannel& channel) {
  return channel.name.starts_with("hgros/") || channel.name.starts_with("params/");
}

void CheckTypes(const KnownChannel& channel, Findings& findings) {
  std::set<std::string> said;
  for (const ChannelUser& from : channel.publishers) {
    for (const ChannelUser& to : channel.subscribers) {
      if (from.type_name.empty() || to.type_name.empty()) continue;
      const std::string both = from.type_name + " " + to.type_name;
      if (from.type_name != to.type_name || from.encoding != to.encoding) {
        if (!said.insert(both).second) continue;
        findings.push_back(
            {Severity::kFault, "type",
             fmt::format("{} publishes {} on \"{}\", but {} subscribes to {}: no message gets there.",
                         ShortName(from, false), from.type_name, channel.name, ShortName(to, false), to.type_name),
             "Use one type in both programs, or give one of the two another channel."});
      } else if (from.fingerprint != 0 && to.fingerprint != 0 && from.fingerprint != to.fingerprint &&
                 said.insert(both).second) {
        findings.push_back({Severity::kNote, "type",
                            fmt::format("{} and {} were built with different versions of {}, the type of \"{}\".",
                                        ShortName(from, false), ShortName(to, false), from.type_name, channel.name),
                            "If fields are missing, build both with one version."});
      }
    }
  }
}

void CheckEnds(const Evidence& evidence, Findings& findings) {
  const auto without = [&](auto KnownChannel::*missing, auto KnownChannel::*present) {
    std::vector<const KnownChannel*> found;
    for (const KnownChannel& channel : evidence.channels) {
      if (!IsInternal(channel) && (channel.*missing).empty() && !(channel.*present).empty()) found.push_back(&channel);
    }
    return found;
  };
  const auto unheard = without(&KnownChannel::subscribers, &KnownChannel::publishers);
  for (const KnownChannel* wanted : without(&KnownChannel::publishers, &KnownChannel::subscribers)) {
    const auto like = std::ranges::find_if(
        unheard, [&](const KnownChannel* other) { return DifferByATypingError(wanted->name, other->name); });
    const std::string_view service = ServiceOf(wanted->name);
    if (!service.empty()) continue;
    if (like != unheard.end()) {
      findings.push_back(
          {Severity::kFault, "name",
           fmt::format(
               "{} subscribes to \"{}\", which nobody publishes. {} publishes \"{}\", to which nobody subscribes.",
               Names(wanted->subscribers), wanted->name, Names((*like)->publishers), (*like)->name),
           "One of the two names is probably misspelled."});
    } else {
      findings.push_back(
          {Severity::kWarning, "publisher",
           fmt::format("Nobody publishes \"{}\", to which {} subscribes.", wanted->name, Names(wanted->subscribers)),
           "Start its publisher, or let its messages pass: lists of channels at endpoints, domain, host."});
    }
  }
  for (const KnownChannel* channel : unheard) {
    findings.push_back(
        {Severity::kNote, "subscriber",
         fmt::format("Nobody subscribes to \"{}\", which {} publishes.", channel->name, Names(channel->publishers)),
         ""});
  }
}

// Differences of one counter of one session between the two readings.
template <class F>
std::uint64_t Growth(const Evidence& evidence, SessionId session, const std::string& channel, const F& counter) {
  const Snapshot::Channel* before = CountersOf(evidence.before, session, channel);
  const Snapshot::Channel* after = CountersOf(evidence.after, session, channel);
  if (before == nullptr || after == nullptr || counter(*after) < counter(*before)) return 0;
  return counter(*after) - counter(*before);
}

void CheckLosses(const Evidence& evidence, const KnownChannel& channel, Findings& findings) {
  for (const ChannelUser& user : channel.publishers) {
    const std::uint64_t dropped =
        Growth(evidence, user.session, channel.name, [](const Snapshot::Channel& one) { return one.send_dropped(); });
    if (dropped > 0) {
      findings.push_back(
          {Severity::kFault, "dropped",
           fmt::format(
               "{} dropped {} messages of \"{}\" in the last second, because a subscriber in another process is too "
               "slow or was cut off.",
               ShortName(user, false), dropped, channel.name),
           "Look for a slow callback or a weak network below, or raise peer_queue_bytes."});
    }
    const std::uint64_t refused =
        Growth(evidence, user.session, channel.name, [](const Snapshot::Channel& one) { return one.refused(); });
    if (refused > 0) {
      findings.push_back(
          {Severity::kFault, "refused",
           fmt::format(
               "{} could not publish {} messages on \"{}\" in the last second: a lossless queue is full, or there "
               "is no memory.",
               ShortName(user, false), refused, channel.name),
           "Make the lossless subscriber faster, give it a larger queue, or let it drop messages (keep-last)."});
    }
  }
  for (const ChannelUser& user : channel.subscribers) {
    const std::uint64_t faults =
        Growth(evidence, user.session, channel.name, [](const Snapshot::Channel& one) { return one.faults(); });
    if (faults > 0) {
      findings.push_back({Severity::kFault, "unreadable",
                          fmt::format("{} received {} packets on \"{}\" in the last second that it cannot read.",
                                      ShortName(user, false), faults, channel.name),
                          "Its log says why."});
    }
    const std::uint64_t lost =
        Growth(evidence, user.session, channel.name, [](const Snapshot::Channel& one) { return one.lost(); });
    if (lost > 0 && user.lossless) {
      findings.push_back(
          {Severity::kFault, "lost",
           fmt::format("{} lost {} messages of \"{}\" in the last second, although it subscribes lossless.",
                       ShortName(user, false), lost, channel.name),
           "Its log, and that of the publisher, say why."});
    }
  }
}

}  // namespace

void CheckChannels(const Evidence& evidence, Findings& findings) {
  CheckEnds(evidence, findings);
  for (const KnownChannel& channel : evidence.channels) {
    CheckTypes(channel, findings);
    CheckLosses(evidence, channel, findings);
  }
}

}  // namespace hgros::cli
