#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace hgros {

// The log names what has not ended after this time.
inline constexpr std::chrono::seconds kHangPatience{2};

// Calls `say` once, on a thread of its own, unless it is destroyed before `patience` has passed. Reports something that
// should have ended by then.
class HangWatch {
 public:
  HangWatch(std::chrono::nanoseconds patience, std::function<void()> say);

 private:
  std::mutex mutex_;
  std::condition_variable_any never_;  // Only the stop request wakes the thread early.
  std::jthread thread_;
};

}  // namespace hgros
