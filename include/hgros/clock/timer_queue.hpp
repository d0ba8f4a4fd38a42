#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>

#include "hgros/base/export.hpp"
#include "hgros/base/listeners.hpp"
#include "hgros/base/log.hpp"
#include "hgros/clock/clock.hpp"
#include "hgros/clock/periodic_schedule.hpp"

namespace hgros {

using TimerCallback = std::function<void(const Tick&)>;

/// Keeps a timer going; move-only. Destroying it ends the timer and waits for a callback of it that runs, unless it is
/// destroyed by that callback.
using Timer = Listening;

struct TimerOptions {
  Missed missed = Missed::kSkip;
  std::optional<Duration> first = {};  ///< From now to the first turn; left out: one period.
  /// False: ending the timer does not wait for its callback, which then keeps alive itself whatever it uses.
  bool waits_at_end = true;
};

/// Any number of timers of one clock on one thread.
///
/// Callbacks run on the queue's thread, one at a time, by their planned moments, and those of one moment in the order
/// in which their timers were made. So they are to be short; what takes longer hands its Tick over to a thread of its
/// own: a session's timer posts it to a graph node. A callback that throws is said in the log, and its timer goes on.
///
/// Thread safety: all of it but the destructor, which waits for the running callback and is not called by one. Timers
/// may outlive their queue; they are then inert.
class HGROS_EXPORT TimerQueue {
 public:
  explicit TimerQueue(std::shared_ptr<Clock> clock, LogSink log = DefaultLogSink());
  TimerQueue(const TimerQueue&) = delete;
  TimerQueue& operator=(const TimerQueue&) = delete;
  ~TimerQueue();

  /// Again and again; see PeriodicSchedule for how that follows the clock. Throws Error unless `period` is above zero.
  [[nodiscard]] Timer Every(Duration period, TimerCallback callback, const TimerOptions& options = {});
  /// Once, when `delay` has elapsed; jumps of the clock do not count.
  [[nodiscard]] Timer After(Duration delay, TimerCallback callback);
  /// Once, when the clock shows `due`, also if it jumps there; at once if that lies behind.
  [[nodiscard]] Timer At(Time due, TimerCallback callback);

  /// Waits until everything that is due by now has run. Returns at once if called by a callback of this queue.
  void Settle();

  [[nodiscard]] std::size_t size() const;  ///< Timers that will still run.
  [[nodiscard]] const std::shared_ptr<Clock>& clock() const noexcept;

 private:
  class Core;
  std::shared_ptr<Core> core_;
};

}  // namespace hgros
