#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>

#include "hgros/base/export.hpp"
#include "hgros/base/log.hpp"
#include "hgros/clock/clock.hpp"
#include "hgros/clock/periodic_schedule.hpp"
#include "hgros/internal/base/listeners.hpp"

namespace hgros {

using TimerCallback = std::function<void(const Tick&)>;

/// Keeps a timer running; move-only. Destroying it ends the timer and waits for its running callback, except inside
/// that callback.
using Timer = Listening;

struct TimerOptions {
  Missed missed = Missed::kSkip;
  std::optional<Duration> first = {};  ///< Time to the first turn; empty: one period.
  /// False: ending the timer does not wait for its callback, which must then keep alive what it uses.
  bool waits_at_end = true;
};

/// Any number of timers of one clock on one thread.
///
/// Callbacks run on the queue's thread, one at a time, in the order of their planned moments, then in the order in
/// which their timers were created. Keep them short: longer work belongs on another thread; a session's timer posts it
/// to a graph node. If a callback throws, that is logged and its timer continues.
///
/// Thread safety: all functions except the destructor, which waits for the running callback and must not be called by
/// one. Timers may outlive their queue; they then do nothing.
class HGROS_EXPORT TimerQueue {
 public:
  explicit TimerQueue(std::shared_ptr<Clock> clock, LogSink log = DefaultLogSink());
  TimerQueue(const TimerQueue&) = delete;
  TimerQueue& operator=(const TimerQueue&) = delete;
  ~TimerQueue();

  /// Runs periodically; PeriodicSchedule explains how that follows the clock. Throws Error unless `period` is positive.
  [[nodiscard]] Timer Every(Duration period, TimerCallback callback, const TimerOptions& options = {});
  /// Runs once after `delay` has elapsed; jumps of the clock are ignored.
  [[nodiscard]] Timer After(Duration delay, TimerCallback callback);
  /// Runs once when the clock shows `due`, also if it jumps there; at once if that has passed.
  [[nodiscard]] Timer At(Time due, TimerCallback callback);

  /// Waits until everything that is due by now has run. Returns at once inside a callback of this queue.
  void Settle();

  [[nodiscard]] Time next() const;         ///< When the next one is due; Time::Never() if none is left.
  [[nodiscard]] std::size_t size() const;  ///< Timers that will still run.
  [[nodiscard]] const std::shared_ptr<Clock>& clock() const noexcept;

 private:
  class Core;
  std::shared_ptr<Core> core_;
};

}  // namespace hgros
