#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>

#include "hgros/base/export.hpp"

namespace hgros {

/// Lets one thread sleep until a moment or until it is woken.
///
/// Thread safety: Wake() from any thread; one thread waits at a time.
class HGROS_EXPORT Sleeper {
 public:
  Sleeper() = default;
  Sleeper(const Sleeper&) = delete;
  Sleeper& operator=(const Sleeper&) = delete;

  /// Ends the current wait, or else the next one.
  void Wake() noexcept;

  /// For clocks. Both return when woken, at the moment, or sometimes for no reason; the second one follows the wall
  /// clock when that is set.
  void WaitUntil(std::chrono::steady_clock::time_point moment);
  void WaitUntil(std::chrono::system_clock::time_point moment);

 private:
  template <class Moment>
  void Wait(Moment moment);

  std::mutex mutex_;
  std::condition_variable woken_up_;
  bool woken_ = false;
};

}  // namespace hgros
