#include "hgros/clock/errand_thread.hpp"

#include <new>
#include <utility>

#include "hgros/base/system_limits.hpp"

namespace hgros {

ErrandThread::ErrandThread(std::shared_ptr<Log> log)
    : log_(std::move(log)),
      thread_(
          StartThread<std::jthread>("the thread for errands", [this](const std::stop_token& stop) { Loop(stop); })) {}

ErrandThread::~ErrandThread() { End(); }

void ErrandThread::End() {
  const std::scoped_lock one_at_a_time(ending_);
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
  // Swapped out, so that errands are destroyed outside the lock.
  decltype(errands_) too_late;
  decltype(later_) not_due;
  const std::scoped_lock lock(mutex_);
  ended_ = true;
  too_late.swap(errands_);
  not_due.swap(later_);
}

void ErrandThread::Post(std::function<void()> errand) {
  {
    const std::scoped_lock lock(mutex_);
    if (ended_) return;
    errands_.push_back(std::move(errand));
  }
  changed_.notify_one();
}

void ErrandThread::PostIn(std::chrono::nanoseconds delay, std::function<void()> errand) {
  {
    const std::scoped_lock lock(mutex_);
    if (ended_) return;
    later_.emplace(std::chrono::steady_clock::now() + delay, std::move(errand));
  }
  changed_.notify_one();
}

bool ErrandThread::WaitForErrand(std::unique_lock<std::mutex>& lock, const std::stop_token& stop) {
  for (;;) {
    while (!later_.empty() && later_.begin()->first <= std::chrono::steady_clock::now()) {
      errands_.push_back(std::move(later_.begin()->second));
      later_.erase(later_.begin());
    }
    if (!errands_.empty()) return true;
    if (stop.stop_requested()) return false;
    const auto changed = [this, known = later_.size()] { return !errands_.empty() || later_.size() != known; };
    if (later_.empty()) {
      changed_.wait(lock, stop, changed);
    } else {
      const auto due = later_.begin()->first;
      changed_.wait_until(lock, stop, due, changed);
    }
  }
}

void ErrandThread::SayNoMemory() noexcept {
  if (!log_) return;
  try {
    log_->WriteLimited(LogLevel::kError, "errand",
                       "There was no memory for a task of the session; it was given up. Raise the memory limit of the "
                       "process or of its control group.");
  } catch (const std::bad_alloc&) {  // It is said with a later errand.
  }
}

void ErrandThread::Loop(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (WaitForErrand(lock, stop)) {
    const std::function<void()> errand = std::move(errands_.front());
    errands_.pop_front();
    lock.unlock();
    try {
      errand();
    } catch (const std::bad_alloc&) {
      SayNoMemory();
    }
    lock.lock();
  }
}

}  // namespace hgros
