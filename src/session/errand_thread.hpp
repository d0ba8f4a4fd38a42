#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <thread>

namespace hgros {

// A thread for what neither a carrier's thread nor a callback may do itself because it can run user code or wait for
// it: runs errands one after the other.
//
// Thread safety: Post(), PostIn() and End() from any thread but its own for End(), also at the same time.
class ErrandThread {
 public:
  ErrandThread();
  ErrandThread(const ErrandThread&) = delete;
  ErrandThread& operator=(const ErrandThread&) = delete;
  ~ErrandThread();

  // Does nothing once End() has returned.
  void Post(std::function<void()> errand);
  // Runs it when `delay` has passed.
  void PostIn(std::chrono::nanoseconds delay, std::function<void()> errand);
  // Runs what is waiting and what that posts, but not what is not due yet, and joins. The destructor does so too, but
  // errands may post through the owner's handle (an optional, a pointer), which must not change while they run.
  void End();

 private:
  void Loop(const std::stop_token& stop);
  // Waits for the next errand; false if the thread is to end. The lock is held.
  [[nodiscard]] bool WaitForErrand(std::unique_lock<std::mutex>& lock, const std::stop_token& stop);

  std::mutex ending_;
  std::mutex mutex_;
  bool ended_ = false;
  std::condition_variable_any changed_;
  std::deque<std::function<void()>> errands_;
  std::multimap<std::chrono::steady_clock::time_point, std::function<void()>> later_;
  std::jthread thread_;
};

}  // namespace hgros
