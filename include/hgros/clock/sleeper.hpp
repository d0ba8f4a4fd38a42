#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>

#include "hgros/base/export.hpp"

namespace hgros {

/// A place for one thread to sleep in until a moment, or until somebody wakes it.
///
/// Thread safety: Wake() from any thread; one thread waits at a time.
class HGROS_EXPORT Sleeper {
 public:
  Sleeper() = default;
  Sleeper(const Sleeper&) = delete;
  Sleeper& operator=(const Sleeper&) = delete;

  /// The wait that is under way returns, or else the next one does at once.
  void Wake() noexcept;

  /// For clocks. Both return when woken, at the moment, or once in a while for no reason; the second one follows the
  /// wall clock when that is set.
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
