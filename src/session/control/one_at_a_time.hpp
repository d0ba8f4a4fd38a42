#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>

namespace hgros {

// Lets one thread in at a time. ThreadSanitizer does not know how a std::timed_mutex waits.
//
// Thread safety: all functions.
class OneAtATime {
 public:
  // Waits until the thread is let in; false at the deadline.
  [[nodiscard]] bool Enter(std::chrono::steady_clock::time_point deadline) {
    std::unique_lock lock(mutex_);
    if (!left_.wait_until(lock, deadline, [this] { return !inside_; })) return false;
    inside_ = true;
    return true;
  }
  void Leave() {
    const std::scoped_lock lock(mutex_);
    inside_ = false;
    left_.notify_one();
  }

 private:
  std::mutex mutex_;
  std::condition_variable left_;
  bool inside_ = false;
};

}  // namespace hgros
