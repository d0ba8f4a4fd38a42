#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace hgros::test {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || defined(HGROS_EMULATED)
inline constexpr auto kPatience = std::chrono::seconds(60);
#else
inline constexpr auto kPatience = std::chrono::seconds(45);
#endif

/// Waits until `predicate` is true, checking every millisecond, and after a while every 5 ms. False after `patience`.
inline bool Await(const std::function<bool()>& predicate, std::chrono::nanoseconds patience = kPatience) {
  using std::chrono::milliseconds;
  const auto begun = std::chrono::steady_clock::now();
  std::mutex mutex;
  std::condition_variable never;
  while (!predicate()) {
    const auto waited = std::chrono::steady_clock::now() - begun;
    if (waited > patience) return false;
    std::unique_lock lock(mutex);
    never.wait_for(lock, std::clamp<std::chrono::nanoseconds>(waited / 16, milliseconds(1), milliseconds(5)));
  }
  return true;
}

/// Waits for `time`. Only for behavior that time itself defines, such as a stalled cable or a slow callback.
inline void Linger(std::chrono::nanoseconds time) {
  (void)Await([] { return false; }, time);
}

/// A barrier where callbacks wait until the test opens it.
class Door {
 public:
  void Open() {
    {
      const std::scoped_lock lock(mutex_);
      open_ = true;
    }
    changed_.notify_all();
  }
  void Pass() {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, kPatience, [this] { return open_; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool open_ = false;
};

}  // namespace hgros::test
