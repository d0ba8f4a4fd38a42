// Limits of this host and of the processes on it, and other sessions that this command does not meet.
#include <fmt/format.h>
#include <sched.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "doctor/evidence.hpp"
#include "robot/domains.hpp"
#include "terminal/units.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kFewFiles = 1024;
constexpr std::uint64_t kSmallBuffer = 1 << 20;
constexpr double kNearlyFull = 0.9;

std::string TextOf(const fs::path& file) {
  std::ifstream in(file);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

std::optional<std::uint64_t> NumberIn(const std::string& text) {
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() ? std::optional(number) : std::nullopt;
}

std::size_t CountFiles(const fs::path& folder) {
  std::error_code error;
  const auto files = fs::directory_iterator(folder, error);
  return error ? 0 : static_cast<std::size_t>(std::distance(files, fs::directory_iterator()));
}

void CheckDescriptors(const std::string& name, std::int64_t pid, Findings& findings) {
  const fs::path folder = fmt::format("/proc/{}", pid);
  const std::string limits = TextOf(folder / "limits");
  const std::size_t line = limits.find("Max open files");
  if (line == std::string::npos) return;
  const std::size_t digits = limits.find_first_of("0123456789", line);
  const std::uint64_t limit = digits == std::string::npos ? 0 : NumberIn(limits.substr(digits, 20)).value_or(0);
  const std::size_t open = CountFiles(folder / "fd");
  if (limit == 0 || open == 0) return;
  if (static_cast<double>(open) > kNearlyFull * static_cast<double>(limit)) {
    findings.push_back({Severity::kWarning, "files", fmt::format("{} has {} of its {} open files.", name, open, limit),
                        "Raise the limit (ulimit -n, or LimitNOFILE= of its systemd unit)."});
  } else if (limit < kFewFiles) {
    findings.push_back({Severity::kNote, "files", fmt::format("{} may open only {} files.", name, limit),
                        "A session that meets many others needs more: ulimit -n 4096."});
  }
}

// Of files, which the system gives up first.
std::uint64_t CachedBytes(const fs::path& group) {
  const std::string stat = TextOf(group / "memory.stat");
  constexpr std::string_view kKey = "inactive_file ";
  const std::size_t line = stat.find(kKey);
  return line == std::string::npos ? 0 : NumberIn(stat.substr(line + kKey.size(), 20)).value_or(0);
}

// The control group of a process, version 2: "0::/path".
void CheckMemoryGroup(const std::string& name, std::int64_t pid, std::set<std::string>& seen, Findings& findings) {
  std::string group = TextOf(fmt::format("/proc/{}/cgroup", pid));
  const std::size_t begin = group.find("0::/");
  if (begin == std::string::npos) return;
  group = group.substr(begin + 3, group.find('\n', begin) - begin - 3);
  for (fs::path at = group; !seen.contains(at.string()); at = at.parent_path()) {
    seen.insert(at.string());
    const fs::path folder = "/sys/fs/cgroup" + at.string();
    const std::optional<std::uint64_t> most = NumberIn(TextOf(folder / "memory.max"));
    std::optional<std::uint64_t> now = NumberIn(TextOf(folder / "memory.current"));
    if (now) *now -= std::min(*now, CachedBytes(folder));
    if (!most || !now || static_cast<double>(*now) < kNearlyFull * static_cast<double>(*most)) continue;
    findings.push_back(
        {Severity::kWarning, "memory",
         fmt::format("The control group {} of {} uses {} of {}.", at.string(), name,
                     BytesText(static_cast<double>(*now), false), BytesText(static_cast<double>(*most), false)),
         "Raise its memory limit (MemoryMax=), or lower shared_memory: limit and the queues of its nodes."});
  }
}

// Whether a thread of that name has a real-time priority; empty: there is none, or its priority is not known.
std::optional<bool> HasPriority(std::int64_t pid, const std::string& thread) {
  std::optional<bool> has;
  std::error_code error;
  for (const auto& task : fs::directory_iterator(fmt::format("/proc/{}/task", pid), error)) {
    if (TextOf(task.path() / "comm") != thread + "\n") continue;
    const int policy = sched_getscheduler(static_cast<pid_t>(NumberIn(task.path().filename().string()).value_or(0)));
    if (policy >= 0) has = has.value_or(false) || (policy & ~SCHED_RESET_ON_FORK) == SCHED_FIFO;
  }
  return has;
}

void CheckPriorities(const std::string& name, const Snapshot& snapshot, Findings& findings) {
  constexpr std::size_t kThreadName = 15;
  for (const Snapshot::Channel& channel : snapshot.channels()) {
    for (const Snapshot::Node& node : channel.nodes()) {
      if (node.fifo_priority() == 0 || HasPriority(snapshot.pid(), node.name().substr(0, kThreadName)) != false)
        continue;
      findings.push_back({Severity::kWarning, "priority",
                          fmt::format("Node {} of {} should have the real-time priority {}, but its thread has none.",
                                      Visible(node.name()), name, node.fifo_priority()),
                          fmt::format("Let the user have it (ulimit -r {}, or LimitRTPRIO= of its systemd unit).",
                                      node.fifo_priority())});
    }
  }
}

void CheckBuffers(const Evidence& evidence, Findings& findings) {
  std::set<std::string> hosts;
  for (const auto& [session, snapshot] : evidence.after) hosts.insert(snapshot->host());
  const std::optional<std::uint64_t> most = NumberIn(TextOf("/proc/sys/net/core/rmem_max"));
  if (hosts.size() < 2 || !most || *most >= kSmallBuffer) return;
  findings.push_back({Severity::kNote, "buffers",
                      fmt::format("Sockets of this host may buffer only {} (net.core.rmem_max).",
                                  BytesText(static_cast<double>(*most), false)),
                      "For large messages from other hosts: sysctl -w net.core.rmem_max=8388608."});
}

void CheckGovernor(Findings& findings) {
  const fs::path folder = "/sys/devices/system/cpu/cpu0/cpufreq";
  const std::string driver = TextOf(folder / "scaling_driver");
  const bool scales_itself = driver.starts_with("intel_pstate") || driver.starts_with("amd-pstate");
  if (scales_itself || !TextOf(folder / "scaling_governor").starts_with("powersave")) return;
  findings.push_back({Severity::kNote, "governor", "The CPU's governor is powersave, which makes short callbacks slow.",
                      "cpupower frequency-set -g performance, or schedutil."});
}

void CheckOtherDomains(const std::string& own, Findings& findings) {
  for (const DomainOnHost& domain : DomainsOnHost()) {
    const std::string folder = domain.folder.string();
    if (domain.stale > 0) {
      findings.push_back({Severity::kNote, "registry",
                          fmt::format("Files of sessions that have ended are left in {} ({}).", folder, domain.stale),
                          "The next session of that user there removes them."});
    }
    if (domain.sessions == 0 || (domain.name == own && !domain.other_user)) continue;
    if (domain.other_user) {
      findings.push_back({Severity::kNote, "domain",
                          fmt::format("Sessions of user {} are in {} ({}); this command does not meet them.",
                                      *domain.other_user, folder, domain.sessions),
                          "Run the command as that user."});
    } else {
      findings.push_back({Severity::kNote, "domain",
                          fmt::format("Sessions are in the domain \"{}\" ({}); this command looked at \"{}\".",
                                      domain.name, domain.sessions, own),
                          "hgros doctor --domain " + domain.name});
    }
  }
}

}  // namespace

void CheckSystem(const Evidence& evidence, Findings& findings) {
  std::set<std::string> groups;
  std::set<std::int64_t> processes;
  for (const auto& [session, snapshot] : evidence.after) {
    if (!evidence.here.contains(session)) continue;
    CheckPriorities(evidence.NameOf(session), *snapshot, findings);
    if (!processes.insert(snapshot->pid()).second) continue;
    CheckDescriptors(evidence.NameOf(session), snapshot->pid(), findings);
    CheckMemoryGroup(evidence.NameOf(session), snapshot->pid(), groups, findings);
  }
  CheckBuffers(evidence, findings);
  CheckGovernor(findings);
  CheckOtherDomains(evidence.domain, findings);
}

}  // namespace hgros::cli
