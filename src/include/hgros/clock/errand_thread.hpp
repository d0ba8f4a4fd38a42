#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <thread>

#include "hgros/base/log.hpp"

namespace hgros {

// Runs errands one after the other on a thread of its own: work that neither a transport's thread nor a callback may do
// itself, because it can run user code or wait for it.
//
// Thread safety: Post() and PostIn() from any thread; End() from any thread but its own.
class ErrandThread {
 public:
  // An errand that throws std::bad_alloc is given up; the log says so.
  explicit ErrandThread(std::shared_ptr<Log> log = nullptr);
  ErrandThread(const ErrandThread&) = delete;
  ErrandThread& operator=(const ErrandThread&) = delete;
  ~ErrandThread();

  // Does nothing after End() has returned.
  void Post(std::function<void()> errand);
  // Runs the errand after `delay`.
  void PostIn(std::chrono::nanoseconds delay, std::function<void()> errand);
  // Runs the waiting errands and those that they post, but not those that are not due yet, and joins. The destructor
  // does the same, but errands may post through the owner's handle (an optional, a pointer), which must not change
  // while they run.
  void End();

 private:
  void SayNoMemory() noexcept;
  void Loop(const std::stop_token& stop);
  // Waits for the next errand; false when the thread has to end. The lock is held.
  [[nodiscard]] bool WaitForErrand(std::unique_lock<std::mutex>& lock, const std::stop_token& stop);

  const std::shared_ptr<Log> log_;  // Maybe null.
  std::mutex ending_;
  std::mutex mutex_;
  bool ended_ = false;
  std::condition_variable_any changed_;
  std::deque<std::function<void()>> errands_;
  std::multimap<std::chrono::steady_clock::time_point, std::function<void()>> later_;
  std::jthread thread_;
};

}  // namespace hgros
