#include "processes/process_end.hpp"

#include <glob.h>
#include <signal.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <system_error>

namespace hgros::cli {

namespace {

std::string SignalText(int status) {
  const char* name = sigabbrev_np(WTERMSIG(status));
  return "SIG" + std::string(name != nullptr ? name : std::to_string(WTERMSIG(status)));
}

std::string FirstLine(const char* path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

}  // namespace

std::string ShortEndText(int status) {
  if (WIFSIGNALED(status)) return "ended by " + SignalText(status);
  return WEXITSTATUS(status) == 0 ? "ended" : "ended with code " + std::to_string(WEXITSTATUS(status));
}

std::string EndText(int status) {
  if (WIFSIGNALED(status)) return "it was ended by " + SignalText(status);
  return "it ended with exit code " + std::to_string(WEXITSTATUS(status));
}

bool HasCrashed(int status, bool components) {
  if (!WIFSIGNALED(status)) return components && WEXITSTATUS(status) > 1;
  const int number = WTERMSIG(status);
  return number != SIGKILL && number != SIGTERM && number != SIGINT && number != SIGHUP;
}

std::string CoreName(const std::string& pattern, bool pid_is_added, pid_t pid, int signal) {
  std::string name;
  bool has_pid = false;
  for (std::size_t at = 0; at < pattern.size(); ++at) {
    if (pattern[at] != '%') {
      name += pattern[at];
      continue;
    }
    if (++at == pattern.size()) break;  // The kernel drops it.
    switch (pattern[at]) {
      case '%': name += '%'; break;
      case 'p':
        has_pid = true;
        name += std::to_string(pid);
        break;
      case 'u': name += std::to_string(getuid()); break;
      case 'g': name += std::to_string(getgid()); break;
      case 's': name += std::to_string(signal); break;
      default: name += '*'; break;
    }
  }
  if (pid_is_added && !has_pid) name += "." + std::to_string(pid);
  return name;
}

std::string CoreText(int status, pid_t pid) {
  if (!WIFSIGNALED(status) || !WCOREDUMP(status)) return {};
  const std::string pattern = FirstLine("/proc/sys/kernel/core_pattern");
  if (pattern.starts_with('|')) return " Its core was given to" + pattern.substr(1, pattern.find(' ') - 1) + ".";
  const bool pid_is_added = FirstLine("/proc/sys/kernel/core_uses_pid") != "0";
  std::error_code error;
  // An absolute pattern stays as it is.
  std::string file =
      (std::filesystem::current_path(error) / CoreName(pattern, pid_is_added, pid, WTERMSIG(status))).string();
  glob_t found{};
  if (file.find('*') != std::string::npos && glob(file.c_str(), 0, nullptr, &found) == 0) file = found.gl_pathv[0];
  globfree(&found);
  return " Its core file: " + file + ".";
}

}  // namespace hgros::cli
