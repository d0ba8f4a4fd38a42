#pragma once

#include <cstddef>

namespace hgros::test {

/// While one exists, this program can allocate no more than this many bytes at once. For programs that are linked with
/// small_memory.cpp, which replaces operator new.
class SmallMemory {
 public:
  explicit SmallMemory(std::size_t most_bytes);
  SmallMemory(const SmallMemory&) = delete;
  SmallMemory& operator=(const SmallMemory&) = delete;
  ~SmallMemory();
};

/// While one exists, its thread can allocate no more than this often. Otherwise as SmallMemory.
class FewAllocations {
 public:
  explicit FewAllocations(std::size_t count);
  FewAllocations(const FewAllocations&) = delete;
  FewAllocations& operator=(const FewAllocations&) = delete;
  ~FewAllocations();
  /// Whether an allocation has failed.
  [[nodiscard]] static bool UsedUp();
};

}  // namespace hgros::test
