#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>

#include "discovery/process_stat.hpp"
#include "hgros/discovery/announcement.hpp"

namespace hgros {

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
