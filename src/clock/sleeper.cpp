#include "hgros/internal/clock/sleeper.hpp"

namespace hgros {

void Sleeper::Wake() noexcept {
  // Holds the lock to the end: the woken thread may destroy this object as soon as it has the lock.
  const std::scoped_lock lock(mutex_);
  woken_ = true;
  woken_up_.notify_one();
}

template <class Moment>
void Sleeper::Wait(Moment moment) {
  std::unique_lock lock(mutex_);
  const auto woken = [this] { return woken_; };
  if (moment == Moment::max()) {
    woken_up_.wait(lock, woken);
  } else {
    woken_up_.wait_until(lock, moment, woken);
  }
  woken_ = false;
}

void Sleeper::WaitUntil(std::chrono::steady_clock::time_point moment) { Wait(moment); }
void Sleeper::WaitUntil(std::chrono::system_clock::time_point moment) { Wait(moment); }

}  // namespace hgros
