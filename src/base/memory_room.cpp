#include "hgros/base/memory_room.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <sstream>
#include <vector>

namespace hgros {
namespace {

// The part of a group's limit that stays free for other needs of its processes: an eighth, within these bounds.
constexpr std::uint64_t kLeastMargin = 8ULL << 20;
constexpr std::uint64_t kLargestMargin = 64ULL << 20;
// In version 1, a huge number means "no limit".
constexpr std::uint64_t kNoLimit = 1ULL << 60;

bool HasWord(const std::string& list, const std::string& word) {
  return ("," + list + ",").find("," + word + ",") != std::string::npos;
}

std::optional<std::uint64_t> ReadNumber(const std::string& path) {
  std::ifstream file(path);
  std::uint64_t number = 0;
  if (!(file >> number)) return std::nullopt;  // "max", or the file does not exist.
  return number;
}

// Memory that the kernel can take back at once.
std::uint64_t CachedBytes(const std::string& path, const std::string& prefix) {
  std::ifstream file(path);
  std::string name;
  std::uint64_t number = 0;
  std::uint64_t sum = 0;
  while (file >> name >> number) {
    if (name == prefix + "inactive_file" || name == prefix + "active_file") sum += number;
  }
  return sum;
}

std::optional<std::uint64_t> RoomOf(const std::string& folder, bool unified) {
  const auto limit = ReadNumber(folder + (unified ? "/memory.max" : "/memory.limit_in_bytes"));
  const auto usage = ReadNumber(folder + (unified ? "/memory.current" : "/memory.usage_in_bytes"));
  if (!limit || !usage || *limit >= kNoLimit) return std::nullopt;
  const std::uint64_t cached = CachedBytes(folder + "/memory.stat", unified ? "" : "total_");
  const std::uint64_t taken = *usage - std::min(*usage, cached) + std::clamp(*limit / 8, kLeastMargin, kLargestMargin);
  return *limit - std::min(*limit, taken);
}

std::uint64_t PageBytes() { return static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)); }

struct Pages {
  std::uint64_t all = 0;
  std::uint64_t resident = 0;
};
Pages PagesOfThisProcess() {
  Pages pages;
  std::ifstream file("/proc/self/statm");
  return file >> pages.all >> pages.resident ? pages : Pages();
}

// The path of the process's group in the hierarchy of that version.
std::optional<std::string> PathOf(const std::string& process, bool unified) {
  std::ifstream file(process + "/cgroup");
  for (std::string line; std::getline(file, line);) {  // Number:controllers:path
    const auto first = line.find(':');
    const auto second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    if (unified ? controllers.empty() : HasWord(controllers, "memory")) return line.substr(second + 1);
  }
  return std::nullopt;
}

}  // namespace

MemoryGroupPlace FindMemoryGroup(const std::string& process) {
  MemoryGroupPlace place;
  auto path = PathOf(process, false);
  place.unified = !path;
  if (!path) path = PathOf(process, true);
  if (!path) return {};
  std::ifstream file(process + "/mountinfo");
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    const std::vector<std::string> fields{std::istream_iterator<std::string>(words), {}};
    const auto dash = std::ranges::find(fields, "-");
    if (fields.size() < 6 || fields.end() - dash < 4) continue;
    const bool fits = place.unified ? dash[1] == "cgroup2" : dash[1] == "cgroup" && HasWord(dash[3], "memory");
    if (!fits) continue;
    const std::string root = fields[3] == "/" ? "" : fields[3];  // The part of the hierarchy that is visible here.
    place.top = fields[4];
    // If the path lies elsewhere, the top is the process's own group, or the group that limits it.
    const bool below = path->starts_with(root + "/") && !path->starts_with(root + "/..");
    place.folder = place.top + (below && *path != "/" ? path->substr(root.size()) : "");
    return place;
  }
  return {};
}

std::optional<std::uint64_t> MemoryGroupRoom(const std::string& process) {
  const MemoryGroupPlace place = FindMemoryGroup(process);
  std::optional<std::uint64_t> room;
  for (std::string folder = place.folder; !place.top.empty(); folder.erase(folder.rfind('/'))) {
    if (const auto here = RoomOf(folder, place.unified)) room = std::min(room.value_or(*here), *here);
    if (folder.size() <= place.top.size()) break;
  }
  return room;
}

std::uint64_t ResidentBytes() { return PagesOfThisProcess().resident * PageBytes(); }

std::optional<std::uint64_t> FreeMemory() {
  std::optional<std::uint64_t> room = MemoryGroupRoom();
  const auto at_most = [&room](std::uint64_t bytes) { room = std::min(room.value_or(bytes), bytes); };
  std::ifstream file("/proc/meminfo");
  std::string name;
  std::string unit;
  std::uint64_t kilobytes = 0;
  while (file >> name >> kilobytes && name != "MemAvailable:") std::getline(file, unit);
  if (file) at_most(kilobytes * 1024);
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY) {
    at_most(limit.rlim_cur - std::min<std::uint64_t>(limit.rlim_cur, PagesOfThisProcess().all * PageBytes()));
  }
  return room;
}

}  // namespace hgros
