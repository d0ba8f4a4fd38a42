#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>

#include "hgros/clock/time.hpp"

namespace hgros {

// Wakes threads that wait for a change of the session, such as a new subscriber.
//
// Thread safety: all functions.
class ChangeSignal {
 public:
  void Notify() noexcept {
    {
      const std::scoped_lock lock(mutex_);
      ++changes_;
    }
    changed_.notify_all();
  }

  // Evaluates the predicates after each change, outside the lock, because both take other locks. False if the timeout
  // expired first, or if `stop` became true and `holds` is still false.
  template <class Holds, class Stop>
  bool WaitUntil(std::chrono::nanoseconds timeout, Holds holds, Stop stop) const {
    const auto deadline = DeadlineIn(timeout);
    for (;;) {
      std::unique_lock lock(mutex_);
      const std::uint64_t seen = changes_;
      lock.unlock();
      if (holds()) return true;
      if (stop()) return false;
      lock.lock();
      if (!changed_.wait_until(lock, deadline, [&] { return changes_ != seen; })) {
        lock.unlock();
        return holds();
      }
    }
  }

 private:
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::uint64_t changes_ = 0;
};

}  // namespace hgros
