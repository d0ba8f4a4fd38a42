// How sessions reach each other: transports, clocks, versions.
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "doctor/evidence.hpp"
#include "robot/offered_params.hpp"
#include "terminal/units.hpp"

namespace hgros::cli {
namespace {

constexpr std::int64_t kLargeOffsetNs = 1'000'000;
constexpr std::string_view kSharedMemory = "shared memory";  // As PeerInfo::transport has it.

// `why`: PeerInfo::why.
std::string AdviceFor(std::string_view why) {
  if (why == "not found on this host") {
    return "Run both as one user in one domain and, in containers, with one /dev/shm, network namespace and "
           "XDG_RUNTIME_DIR.";
  }
  if (why == "discovery on this host is off") return "Set `discovery: {local: true}` in the files of both.";
  return "The warning \"does not reach it\" in their logs names what is in the way.";
}

void CheckTransports(const Evidence& evidence, Findings& findings) {
  std::set<std::pair<SessionId, SessionId>> said;
  for (const auto& [session, snapshot] : evidence.after) {
    if (!evidence.here.contains(session)) continue;
    for (const Snapshot::Peer& peer : snapshot->peers()) {
      const SessionId other{peer.session()};
      if (peer.transport() == kSharedMemory || !evidence.here.contains(other)) continue;
      // Two that move to shared memory just now were otherwise before.
      const auto before = evidence.before.find(session);
      const bool lasting = before != evidence.before.end() &&
                           std::ranges::any_of(before->second->peers(), [&](const Snapshot::Peer& one) {
                             return one.session() == peer.session() && one.transport() == peer.transport();
                           });
      if (!lasting || !said.insert(std::minmax(session, other)).second) continue;
      findings.push_back({Severity::kWarning, "transport",
                          fmt::format("{} and {} are on one host, but exchange messages over {}: {}.",
                                      evidence.NameOf(session), evidence.NameOf(other), peer.transport(), peer.why()),
                          AdviceFor(peer.why())});
    }
  }
}

void CheckClocks(const Evidence& evidence, Findings& findings) {
  std::set<std::string> said;  // One of each host.
  for (const auto& [session, offset] : evidence.offsets) {
    const std::int64_t nanoseconds = offset.offset.count();
    const std::int64_t size = nanoseconds < 0 ? -std::max(nanoseconds, -INT64_MAX) : nanoseconds;
    if (size <= kLargeOffsetNs || size - kLargeOffsetNs <= offset.uncertainty.count()) continue;
    const auto counters = evidence.after.find(session);
    const std::string host = counters == evidence.after.end() ? evidence.NameOf(session) : counters->second->host();
    if (!said.insert(host).second) continue;
    findings.push_back({Severity::kWarning, "clock",
                        fmt::format("The clock of {} is {} {} this host's.", host, DurationText(size, false),
                                    nanoseconds > 0 ? "ahead of" : "behind"),
                        "Synchronize the clocks (chrony, systemd-timesyncd, PTP); stamps and ages are wrong by that "
                        "much."});
  }
}

void CheckSilent(const Evidence& evidence, Findings& findings) {
  for (const auto& [session, user] : evidence.silent) {
    findings.push_back({Severity::kFault, "silent",
                        fmt::format("{} does not answer. It is stopped, overloaded, or hangs.", ShortName(user, false)),
                        "Look at its process with top or gdb; continue it if it was stopped (kill -CONT)."});
  }
}

void CheckParams(const Evidence& evidence, Findings& findings) {
  for (const KnownChannel& channel : evidence.channels) {
    const std::string twice = OfferedTwice(channel);
    if (twice.empty() || OfferedTwice(ChannelNamed(evidence.channels_before, channel.name)) != twice) continue;
    findings.push_back({Severity::kFault, "params", twice + " A change goes to all, and any of them answers.",
                        std::string(kRenameSession)});
  }
}

void CheckVersions(const Evidence& evidence, Findings& findings) {
  std::map<std::string, std::string> programs;
  for (const auto& [session, snapshot] : evidence.after) {
    std::string& names = programs[snapshot->version().empty() ? "an older one" : snapshot->version()];
    names += (names.empty() ? "" : ", ") + evidence.NameOf(session);
  }
  if (programs.size() < 2) return;
  std::string all;
  for (const auto& [version, names] : programs) all += (all.empty() ? "" : "; ") + version + " in " + names;
  findings.push_back({Severity::kNote, "version", "Sessions use different versions of the library: " + all + ".",
                      "Update all programs to one version."});
}

}  // namespace

void CheckSessions(const Evidence& evidence, Findings& findings) {
  CheckSilent(evidence, findings);
  CheckTransports(evidence, findings);
  CheckClocks(evidence, findings);
  CheckParams(evidence, findings);
  CheckVersions(evidence, findings);
}

}  // namespace hgros::cli
