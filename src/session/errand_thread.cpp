#include "session/errand_thread.hpp"

#include <utility>

namespace hgros {

ErrandThread::ErrandThread() : thread_([this](const std::stop_token& stop) { Loop(stop); }) {}

ErrandThread::~ErrandThread() {
  thread_.request_stop();
  thread_.join();
}

void ErrandThread::Post(std::function<void()> errand) {
  {
    const std::scoped_lock lock(mutex_);
    errands_.push_back(std::move(errand));
  }
  changed_.notify_one();
}

void ErrandThread::Loop(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, stop, [this] { return !errands_.empty(); });
    if (errands_.empty()) return;
    const std::function<void()> errand = std::move(errands_.front());
    errands_.pop_front();
    lock.unlock();
    errand();
    lock.lock();
  }
}

}  // namespace hgros
