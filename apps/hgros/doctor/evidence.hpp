#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "doctor/finding.hpp"
#include "hgros/bridge/known_channel.hpp"
#include "hgros/clock/clock_offset.hpp"
#include "robot/overview.hpp"

namespace hgros::cli {

/// What the checks look at. Counters are read twice, so that only what happens now is reported.
struct Evidence {
  std::string domain;  ///< Of this command.
  std::vector<KnownChannel> channels;
  std::vector<KnownChannel> channels_before;
  AllCounters before;
  AllCounters after;
  std::map<SessionId, ClockOffset> offsets;   ///< Of sessions on other hosts.
  std::set<SessionId> here;                   ///< On this host, as far as is known for sure: reached by shared memory.
  std::map<SessionId, std::string> names;     ///< "talker:4711"
  std::map<SessionId, ChannelUser> silent;    ///< Did not answer.
  std::map<std::string, std::string> frames;  ///< By channel: the frame of one of its messages.
  std::set<std::string> known_frames;         ///< That transforms have.

  /// The name of a session; its id if it is not known.
  [[nodiscard]] std::string NameOf(SessionId session) const;
  /// Between the two readings of a session; 0 if there are not two.
  [[nodiscard]] double SecondsOf(SessionId session) const;
  /// How much a counter of a session on a channel has grown between them; 0 if there are not two.
  [[nodiscard]] std::uint64_t GrowthOf(SessionId session, const std::string& channel,
                                       std::uint64_t (Snapshot::Channel::*counter)() const) const;
};

/// 0 if the counter began again.
[[nodiscard]] constexpr std::uint64_t Growth(std::uint64_t before, std::uint64_t after) noexcept {
  return after > before ? after - before : 0;
}

// One for each subject; each adds what it finds.
void CheckChannels(const Evidence& evidence, Findings& findings);
void CheckForbidden(const Evidence& evidence, Findings& findings);
void CheckNodes(const Evidence& evidence, Findings& findings);
void CheckSessions(const Evidence& evidence, Findings& findings);
/// Also reads /proc and /sys, and the folders of the registry.
void CheckSystem(const Evidence& evidence, Findings& findings);

/// Whether a subscriber receives the channel from a session that this command does not meet, such as on another host.
[[nodiscard]] bool HasFarPublishers(const Evidence& evidence, const KnownChannel& channel);
/// Whether a session that uses the channel keeps it from leaving or entering.
[[nodiscard]] bool IsKeptFromOthers(const Evidence& evidence, const std::string& channel);

}  // namespace hgros::cli
