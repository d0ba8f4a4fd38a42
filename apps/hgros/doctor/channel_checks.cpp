// Types that do not fit, ends that do not meet, and messages that are lost on the way.
#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "doctor/evidence.hpp"
#include "hgros/base/names.hpp"
#include "hgros/tf/transforms.hpp"

namespace hgros::cli {
namespace {

std::string Names(const std::vector<ChannelUser>& users) {
  constexpr std::size_t kMost = 3;
  std::string names;
  for (std::size_t i = 0; i < std::min(users.size(), kMost); ++i)
    names += (i == 0 ? "" : ", ") + ShortName(users[i], false);
  return users.size() <= kMost ? names : names + fmt::format(" and {} more", users.size() - kMost);
}

// The type, and the encoding if only that differs.
std::string TypeOf(const ChannelUser& user, const ChannelUser& other) {
  if (user.type_name != other.type_name) return user.type_name;
  return user.type_name + (user.encoding == Encoding::kProtobuf ? " as protobuf" : " in another encoding");
}

void CheckTypes(const KnownChannel& channel, Findings& findings) {
  std::set<std::string> said;
  for (const ChannelUser& from : channel.publishers) {
    for (const ChannelUser& to : channel.subscribers) {
      if (from.type_name.empty() || to.type_name.empty()) continue;
      const std::string both = from.type_name + " " + to.type_name;
      if (from.type_name != to.type_name || from.encoding != to.encoding) {
        if (!said.insert(both).second) continue;
        findings.push_back({Severity::kFault, "type",
                            fmt::format("{} publishes {} on \"{}\", but {} subscribes to {}: messages reach it "
                                        "only if it takes bytes (FromAnyRaw).",
                                        ShortName(from, false), TypeOf(from, to), channel.name, ShortName(to, false),
                                        TypeOf(to, from)),
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

// A published channel whose name differs by a typing error; null: none was found in `comparisons`, which it reduces.
const KnownChannel* PublishedLike(const Evidence& evidence, const std::string& name, std::size_t& comparisons) {
  for (const KnownChannel& one : evidence.channels) {
    if (one.publishers.empty() || IsInternal(one.name)) continue;
    if (comparisons == 0) return nullptr;
    --comparisons;
    if (DifferByATypingError(name, one.name)) return &one;
  }
  return nullptr;
}

// Transforms subscribes to two channels, and robots without moving or without fixed frames publish only one of them.
bool HasOtherTransforms(const Evidence& evidence, std::string_view name) {
  if (name != kTransformsChannel && name != kStaticTransformsChannel) return false;
  const std::string_view other = name == kTransformsChannel ? kStaticTransformsChannel : kTransformsChannel;
  return std::ranges::any_of(evidence.channels, [other](const KnownChannel& channel) {
    return channel.name == other && !channel.publishers.empty();
  });
}

void CheckEnds(const Evidence& evidence, Findings& findings) {
  const auto without = [&](auto KnownChannel::*missing, auto KnownChannel::*present) {
    std::vector<const KnownChannel*> found;
    for (const KnownChannel& channel : evidence.channels) {
      if (!IsInternal(channel.name) && (channel.*missing).empty() && !(channel.*present).empty())
        found.push_back(&channel);
    }
    return found;
  };
  // A program that is starting may lack the other end for a moment.
  const auto was_so = [&](const KnownChannel& now, auto KnownChannel::*missing) {
    const auto before = std::ranges::lower_bound(evidence.channels_before, now.name, {}, &KnownChannel::name);
    return before != evidence.channels_before.end() && before->name == now.name && ((*before).*missing).empty();
  };
  constexpr std::size_t kMostCompared = 200;  // Each is compared with each.
  std::size_t comparisons = 1'000'000;
  auto unheard = without(&KnownChannel::subscribers, &KnownChannel::publishers);
  // Later this command itself may be one of them.
  std::erase_if(unheard, [&](const KnownChannel* one) { return TotalsOf(evidence.before, *one).far_subscribers > 0; });
  for (const KnownChannel* wanted : without(&KnownChannel::publishers, &KnownChannel::subscribers)) {
    if (!was_so(*wanted, &KnownChannel::publishers) || IsKeptFromOthers(evidence, wanted->name)) continue;
    if (HasFarPublishers(evidence, *wanted)) continue;
    if (HasOtherTransforms(evidence, wanted->name)) continue;
    const auto compared = std::span(unheard).first(std::min(unheard.size(), kMostCompared));
    const auto like = std::ranges::find_if(
        compared, [&](const KnownChannel* other) { return DifferByATypingError(wanted->name, other->name); });
    if (like != compared.end()) {
      findings.push_back(
          {Severity::kFault, "name",
           fmt::format(
               "{} subscribes to \"{}\", which nobody publishes. {} publishes \"{}\", to which nobody subscribes.",
               Names(wanted->subscribers), wanted->name, Names((*like)->publishers), (*like)->name),
           "One of the two names is probably misspelled."});
      continue;
    }
    const std::string nobody =
        fmt::format("Nobody publishes \"{}\", to which {} subscribes.", wanted->name, Names(wanted->subscribers));
    const KnownChannel* near = PublishedLike(evidence, wanted->name, comparisons);
    if (near != nullptr) {
      findings.push_back({Severity::kWarning, "name",
                          fmt::format("{} {} publishes \"{}\".", nobody, Names(near->publishers), near->name),
                          "The name is probably misspelled."});
    } else {
      findings.push_back(
          {Severity::kWarning, "publisher", nobody,
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

// Two channels, of which each has a publisher: CheckEnds() reports others.
void CheckSlashes(const Evidence& evidence, Findings& findings) {
  for (const KnownChannel& channel : evidence.channels) {
    if (!channel.name.starts_with('/')) continue;
    const KnownChannel other = ChannelNamed(evidence.channels, channel.name.substr(1));
    if (channel.publishers.empty() || other.publishers.empty()) continue;
    findings.push_back({Severity::kWarning, "name",
                        fmt::format("\"{}\", which {} publishes, and \"{}\", which {} publishes, are two channels.",
                                    channel.name, Names(channel.publishers), other.name, Names(other.publishers)),
                        "A slash at the beginning belongs to the name. Use one of the two names."});
  }
}

void CheckFrames(const Evidence& evidence, Findings& findings) {
  const auto is_far = [&](std::string_view transforms) {
    return HasFarPublishers(evidence, ChannelNamed(evidence.channels, std::string(transforms)));
  };
  if (evidence.known_frames.empty() || is_far(kTransformsChannel) || is_far(kStaticTransformsChannel)) return;
  const std::vector<std::string> known(evidence.known_frames.begin(), evidence.known_frames.end());
  for (const auto& [channel, frame] : evidence.frames) {
    if (evidence.known_frames.contains(frame)) continue;
    const std::string nearest = NearestName(frame, known);
    findings.push_back({Severity::kWarning, "frame",
                        fmt::format("\"{}\" of {} is in frame \"{}\", which no transform had within two seconds.{}",
                                    channel, Names(ChannelNamed(evidence.channels, channel).publishers), frame,
                                    nearest.empty() ? "" : " The nearest frame is \"" + nearest + "\"."),
                        "Send the transform of that frame, or correct the frame_id of the messages."});
  }
}

// How fast a counter of a session grows, per second.
double RateOf(const Evidence& evidence, SessionId session, const std::string& channel,
              std::uint64_t (Snapshot::Channel::*counter)() const) {
  const double seconds = evidence.SecondsOf(session);
  return seconds > 0 ? static_cast<double>(evidence.GrowthOf(session, channel, counter)) / seconds : 0;
}

void CheckLosses(const Evidence& evidence, const KnownChannel& channel, Findings& findings) {
  for (const ChannelUser& user : channel.publishers) {
    const double dropped = RateOf(evidence, user.session, channel.name, &Snapshot::Channel::send_dropped);
    if (dropped > 0) {
      findings.push_back(
          {Severity::kFault, "dropped",
           fmt::format("{} drops {:.1f} messages per second of \"{}\", because a subscriber in another process is too "
                       "slow or was cut off.",
                       ShortName(user, false), dropped, channel.name),
           "Look for a slow callback or a weak network below, or raise peer_queue_bytes."});
    }
    const double refused = RateOf(evidence, user.session, channel.name, &Snapshot::Channel::refused);
    if (refused > 0) {
      findings.push_back(
          {Severity::kWarning, "refused",
           fmt::format(
               "{} cannot publish {:.1f} messages per second on \"{}\": a lossless queue is full, or there is no "
               "memory. Unless the program tries again, they are lost.",
               ShortName(user, false), refused, channel.name),
           "Make the lossless subscriber faster, give it a larger queue, or let it drop messages (keep-last)."});
    }
  }
  for (const ChannelUser& user : channel.subscribers) {
    const double faults = RateOf(evidence, user.session, channel.name, &Snapshot::Channel::faults);
    if (faults > 0) {
      findings.push_back({Severity::kFault, "unreadable",
                          fmt::format("{} receives {:.1f} packets per second on \"{}\" that it cannot read.",
                                      ShortName(user, false), faults, channel.name),
                          "Its log says why."});
    }
    const double lost = RateOf(evidence, user.session, channel.name, &Snapshot::Channel::lost);
    if (lost > 0 && user.lossless) {
      findings.push_back({Severity::kFault, "lost",
                          fmt::format("{} loses {:.1f} messages per second of \"{}\", although its queue is lossless.",
                                      ShortName(user, false), lost, channel.name),
                          "Its log, and that of the publisher, say why."});
    }
  }
}

}  // namespace

bool HasFarPublishers(const Evidence& evidence, const KnownChannel& channel) {
  return TotalsOf(evidence.after, channel).far_publishers > 0;
}

void CheckChannels(const Evidence& evidence, Findings& findings) {
  CheckEnds(evidence, findings);
  CheckSlashes(evidence, findings);
  CheckFrames(evidence, findings);
  for (const KnownChannel& channel : evidence.channels) {
    CheckTypes(channel, findings);
    CheckLosses(evidence, channel, findings);
  }
}

}  // namespace hgros::cli
