#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace hgros {

// Speaks up if something that should end soon has not ended after a while: calls `say` once, from a thread of its own,
// unless it is destroyed before.
class HangWatch {
 public:
  HangWatch(std::chrono::nanoseconds patience, std::function<void()> say);

 private:
  std::mutex mutex_;
  std::condition_variable_any never_;  // Only the stop request wakes the thread early.
  std::jthread thread_;
};

}  // namespace hgros
