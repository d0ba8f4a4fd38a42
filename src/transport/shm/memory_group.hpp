#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace hgros::shm {

/// How many more bytes this process can take before its memory control group (cgroup, version 1 or 2), or one above it
/// that can be seen, is nearly full; nothing if none has a limit. Files that the kernel only caches count as free, and
/// something is left for everything else that the group does.
///
/// Where a group is full the kernel does not refuse memory: it ends a process of the group. `process`: where the kernel
/// describes it.
[[nodiscard]] std::optional<std::uint64_t> MemoryGroupRoom(const std::string& process = "/proc/self");

/// Where the process's memory control group is mounted; empty if there is none.
struct MemoryGroupPlace {
  std::string top;     ///< The uppermost group that can be seen.
  std::string folder;  ///< Its own: `top`, or below it.
  bool unified = false;
};
[[nodiscard]] MemoryGroupPlace FindMemoryGroup(const std::string& process = "/proc/self");

}  // namespace hgros::shm
