#pragma once

#include <algorithm>
#include <mutex>

namespace hgros {

// Tells the processor that the thread only waits; some ten nanoseconds.
inline void PauseBriefly() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

// Takes a lock that is held for well under a microsecond: looks again a while before it lets the kernel put the thread
// to sleep, which costs tens of times as much as the wait. Ever less often, since each look takes the lock's cache line
// away from who holds it.
inline void SpinThenLock(std::unique_lock<std::mutex>& lock) {
  constexpr int kLooks = 12;
  constexpr int kMostPauses = 32;
  for (int look = 0, pauses = 1; look < kLooks; ++look, pauses = std::min(2 * pauses, kMostPauses)) {
    if (lock.try_lock()) return;
    for (int i = 0; i < pauses; ++i) PauseBriefly();
  }
  lock.lock();
}

}  // namespace hgros
