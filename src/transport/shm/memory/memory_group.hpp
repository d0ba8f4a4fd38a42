#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace hgros::shm {

/// How many more bytes this process can allocate before its memory control group (cgroup, version 1 or 2), or a visible
/// group above it, is nearly full; none if no group has a limit. Cached files count as free, and some memory stays free
/// for other needs of the group.
///
/// When a group is full, the kernel does not refuse memory: it kills a process of the group. `process`: the process's
/// folder, such as /proc/self.
[[nodiscard]] std::optional<std::uint64_t> MemoryGroupRoom(const std::string& process = "/proc/self");

/// The folders of the process's memory control group; empty if there is none.
struct MemoryGroupPlace {
  std::string top;     ///< The uppermost visible group.
  std::string folder;  ///< The process's group: `top`, or below it.
  bool unified = false;
};
[[nodiscard]] MemoryGroupPlace FindMemoryGroup(const std::string& process = "/proc/self");

}  // namespace hgros::shm
