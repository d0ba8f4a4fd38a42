// How sessions reach each other: transports, clocks, versions.
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "doctor/evidence.hpp"
#include "terminal/units.hpp"

namespace hgros::cli {
namespace {

constexpr std::int64_t kLargeOffsetNs = 1'000'000;

void CheckTransports(const Evidence& evidence, Findings& findings) {
  std::set<std::pair<SessionId, SessionId>> said;
  for (const auto& [session, snapshot] : evidence.after) {
    for (const Snapshot::Peer& peer : snapshot->peers()) {
      const SessionId other{peer.session()};
      const auto counters = evidence.after.find(other);
      if (peer.transport() == "shared memory" || counters == evidence.after.end()) continue;
      if (counters->second->host() != snapshot->host() || !said.insert(std::minmax(session, other)).second) continue;
      findings.push_back({Severity::kWarning, "transport",
                          fmt::format("{} and {} are on one host, but exchange messages over {}: {}.",
                                      evidence.NameOf(session), evidence.NameOf(other), peer.transport(), peer.why()),
                          "Run both as one user in one domain and, in containers, with one /dev/shm, network namespace "
                          "and XDG_RUNTIME_DIR."});
    }
  }
}

void CheckClocks(const Evidence& evidence, Findings& findings) {
  for (const auto& [session, offset] : evidence.offsets) {
    if (std::abs(offset.offset.count()) <= kLargeOffsetNs + offset.uncertainty.count()) continue;
    const std::int64_t size = std::abs(offset.offset.count());
    findings.push_back(
        {Severity::kWarning, "clock",
         fmt::format("The clock of {} is {} {} this host's.", evidence.NameOf(session), DurationText(size, false),
                     offset.offset.count() > 0 ? "ahead of" : "behind"),
         "Synchronize the clocks (chrony, systemd-timesyncd, PTP); stamps and ages are wrong by as much."});
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
  CheckTransports(evidence, findings);
  CheckClocks(evidence, findings);
  CheckVersions(evidence, findings);
}

}  // namespace hgros::cli
