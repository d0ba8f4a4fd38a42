#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace hgros {

// A thread for what neither a carrier's thread nor a callback may do itself because it can run user code or wait for
// it: runs errands one after the other.
//
// Thread safety: Post() from any thread. The destructor runs what is waiting and joins.
class ErrandThread {
 public:
  ErrandThread();
  ErrandThread(const ErrandThread&) = delete;
  ErrandThread& operator=(const ErrandThread&) = delete;
  ~ErrandThread();

  void Post(std::function<void()> errand);

 private:
  void Loop(const std::stop_token& stop);

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<std::function<void()>> errands_;
  std::jthread thread_;
};

}  // namespace hgros
