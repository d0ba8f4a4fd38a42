#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "doctor/finding.hpp"
#include "hgros/bridge/known_channel.hpp"
#include "hgros/clock/clock_offset.hpp"
#include "robot/overview.hpp"

namespace hgros::cli {

/// What the checks look at. Counters are read twice, so that only what happens now is reported.
struct Evidence {
  std::vector<KnownChannel> channels;
  AllCounters before;
  AllCounters after;
  std::map<SessionId, ClockOffset> offsets;  ///< Of sessions on other hosts.
  std::string host;                          ///< Of this command.

  /// The user of a channel who is that session, as "talker:4711"; its id if it is not known.
  [[nodiscard]] std::string NameOf(SessionId session) const;
};

// One for each subject; each adds what it finds.
void CheckChannels(const Evidence& evidence, Findings& findings);
void CheckNodes(const Evidence& evidence, Findings& findings);
void CheckSessions(const Evidence& evidence, Findings& findings);
/// Also reads /proc and /sys, and the folders of the registry.
void CheckSystem(const Evidence& evidence, Findings& findings);

}  // namespace hgros::cli
