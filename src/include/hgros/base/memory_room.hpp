#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "hgros/base/export.hpp"

namespace hgros {

/// How many more bytes this process can allocate before its memory control group (cgroup, version 1 or 2), or a visible
/// group above it, is nearly full; none if no group has a limit. Cached files count as free, and some memory stays free
/// for other needs of the group.
///
/// When a group is full, the kernel does not refuse memory: it kills a process of the group. `process`: the process's
/// folder, such as /proc/self.
[[nodiscard]] HGROS_EXPORT std::optional<std::uint64_t> MemoryGroupRoom(const std::string& process = "/proc/self");

/// The folders of the process's memory control group; empty if there is none.
struct MemoryGroupPlace {
  std::string top;     ///< The uppermost visible group.
  std::string folder;  ///< The process's group: `top`, or below it.
  bool unified = false;
};
[[nodiscard]] HGROS_EXPORT MemoryGroupPlace FindMemoryGroup(const std::string& process = "/proc/self");

/// How many more bytes this process can allocate: the least of MemoryGroupRoom(), the host's free memory and the limit
/// of its address space. None if nothing is known.
[[nodiscard]] HGROS_EXPORT std::optional<std::uint64_t> FreeMemory();

/// The memory of this process that is not swapped out; 0 if it is not known.
[[nodiscard]] HGROS_EXPORT std::uint64_t ResidentBytes();

}  // namespace hgros
