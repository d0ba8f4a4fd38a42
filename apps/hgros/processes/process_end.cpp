#include "processes/process_end.hpp"

#include <string.h>
#include <sys/wait.h>

#include <filesystem>
#include <fstream>
#include <system_error>

namespace hgros::cli {

namespace {

std::string SignalText(int status) {
  const char* name = sigabbrev_np(WTERMSIG(status));
  return "SIG" + std::string(name != nullptr ? name : std::to_string(WTERMSIG(status)));
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

std::string CoreText(int status) {
  if (!WIFSIGNALED(status) || !WCOREDUMP(status)) return {};
  std::ifstream file("/proc/sys/kernel/core_pattern");
  std::string pattern;
  std::getline(file, pattern);
  if (pattern.starts_with('|')) return " Its core was given to" + pattern.substr(1, pattern.find(' ') - 1) + ".";
  if (pattern.starts_with('/')) return " Its core file: " + pattern + ".";
  std::error_code error;
  return " Its core file: " + (std::filesystem::current_path(error) / pattern).string() + ".";
}

}  // namespace hgros::cli
