#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <system_error>

#include "discovery/process_stat.hpp"
#include "hgros/discovery/announcement.hpp"

namespace hgros {

// The second field, the name, may contain spaces and parentheses.
std::optional<discovery::ProcessStat> discovery::ReadProcessStat(const std::string& path) {
  std::ifstream file(path);
  std::string text;
  std::getline(file, text);
  const std::size_t name_end = text.rfind(')');
  if (name_end == std::string::npos) return std::nullopt;
  std::istringstream rest(text.substr(name_end + 1));
  ProcessStat stat;
  rest >> stat.state;
  std::string skipped;
  for (int field = 4; field < 22; ++field) rest >> skipped;
  rest >> stat.start_time;
  return stat;
}

Announcement AnnouncementOfThisProcess(SessionId session, std::uint64_t incarnation) {
  Announcement own;
  own.session = session;
  own.incarnation = incarnation;
  std::error_code none;
  own.process = std::filesystem::read_symlink("/proc/self/exe", none).filename().string();
  char host[256] = {};
  if (gethostname(host, sizeof host - 1) == 0) own.host = host;
  own.pid = getpid();
  own.pid_start_time = discovery::ReadProcessStat("/proc/self/stat").value_or(discovery::ProcessStat()).start_time;
  std::ifstream("/proc/sys/kernel/random/boot_id") >> own.boot_id;
  struct stat network {};
  if (stat("/proc/self/ns/net", &network) == 0) own.network = network.st_ino;
  return own;
}

}  // namespace hgros
