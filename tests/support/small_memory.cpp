#include "support/small_memory.hpp"

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <new>

namespace hgros::test {
namespace {

std::atomic<std::size_t> most_bytes{SIZE_MAX};
thread_local std::size_t left = SIZE_MAX;
thread_local bool used_up = false;

bool Allows(std::size_t bytes) noexcept {
  if (left == 0) used_up = true;
  if (left == 0 || bytes > most_bytes.load(std::memory_order_relaxed)) return false;
  if (left != SIZE_MAX) --left;
  return true;
}

}  // namespace

SmallMemory::SmallMemory(std::size_t most) { most_bytes = most; }
SmallMemory::~SmallMemory() { most_bytes = SIZE_MAX; }

FewAllocations::FewAllocations(std::size_t count) {
  left = count;
  used_up = false;
}
FewAllocations::~FewAllocations() { left = SIZE_MAX; }
bool FewAllocations::UsedUp() { return used_up; }

}  // namespace hgros::test

void* operator new(std::size_t bytes) {
  void* const memory = hgros::test::Allows(bytes) ? std::malloc(bytes == 0 ? 1 : bytes) : nullptr;
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
// AddressSanitizer has its own, which would not fit the delete below.
void* operator new(std::size_t bytes, const std::nothrow_t& /*nothrow*/) noexcept {
  return hgros::test::Allows(bytes) ? std::malloc(bytes == 0 ? 1 : bytes) : nullptr;
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, const std::nothrow_t& /*nothrow*/) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t /*bytes*/) noexcept { std::free(memory); }
