#pragma once

#include <algorithm>
#include <mutex>

namespace hgros {

// Tells the processor that the thread only waits; about ten nanoseconds.
inline void PauseBriefly() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

// Takes a lock that is held for well under a microsecond. Spins for a while before it lets the thread sleep, because
// sleeping costs tens of times as much as the wait. The pauses between tries grow, because each try takes the cache
// line away from the holder.
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
