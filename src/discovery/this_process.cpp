#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <system_error>

#include "hgros/discovery/announcement.hpp"

namespace hgros {
namespace {

// The 22nd field of /proc/self/stat (proc(5)). The second one, the name, may contain spaces and parentheses.
std::uint64_t StartTime() {
  std::ifstream file("/proc/self/stat");
  std::string text;
  std::getline(file, text);
  const std::size_t name_end = text.rfind(')');
  if (name_end == std::string::npos) return 0;
  std::istringstream rest(text.substr(name_end + 1));
  std::string skipped;
  for (int field = 3; field < 22; ++field) rest >> skipped;
  std::uint64_t ticks = 0;
  rest >> ticks;
  return ticks;
}

}  // namespace

Announcement AnnouncementOfThisProcess(SessionId session, std::uint64_t incarnation) {
  Announcement own;
  own.session = session;
  own.incarnation = incarnation;
  std::error_code none;
  own.process = std::filesystem::read_symlink("/proc/self/exe", none).filename().string();
  char host[256] = {};
  if (gethostname(host, sizeof host - 1) == 0) own.host = host;
  own.pid = getpid();
  own.pid_start_time = StartTime();
  std::ifstream("/proc/sys/kernel/random/boot_id") >> own.boot_id;
  return own;
}

}  // namespace hgros
