#pragma once

#include <mutex>

namespace hgros {

// Takes a lock that is held for well under a microsecond: looks again a while before it lets the kernel put the thread
// to sleep, which costs tens of times as much as the wait.
inline void SpinThenLock(std::unique_lock<std::mutex>& lock) {
  constexpr int kLooks = 200;
  for (int i = 0; i < kLooks; ++i) {
    if (lock.try_lock()) return;
#if defined(__x86_64__)
    __builtin_ia32_pause();
#elif defined(__aarch64__)
    asm volatile("yield");
#endif
  }
  lock.lock();
}

}  // namespace hgros
