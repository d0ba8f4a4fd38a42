#pragma once

#include <functional>
#include <stop_token>

#include "hgros/base/export.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/internal/base/listeners.hpp"
#include "hgros/internal/clock/sleeper.hpp"

namespace hgros {

/// A clock's time, and how much of it comes from jumps: `now - jumped` is continuous.
struct ClockReading {
  Time now;
  Duration jumped{0};  ///< The sum of all jumps so far; jumps back are negative.

  [[nodiscard]] Time elapsed() const noexcept { return now - jumped; }
};

/// A clock was set from `before` to `after`.
struct ClockJump {
  Time before;
  Time after;
};
using JumpCallback = std::function<void(const ClockJump&)>;

/// A source of time: the system's clock, a steady clock, one that starts at a reference, a simulated clock. Everything
/// that waits does so on a clock and follows its jumps, pauses and changes of rate.
///
/// Contract for every clock:
///  1. It never goes back between jumps.
///  2. A wait returns when its moment comes, and when the clock jumps or changes its rate. The waiting thread then
///     reads the clock again and decides.
///  3. No jump is lost between a reading and a wait that is given this reading.
///  4. A listener is called for every jump, once the clock shows the new time to all threads.
///
/// Thread safety: all functions.
class HGROS_EXPORT Clock {
 public:
  Clock() = default;
  Clock(const Clock&) = delete;
  Clock& operator=(const Clock&) = delete;
  virtual ~Clock() = default;

  [[nodiscard]] virtual ClockReading Read() const = 0;
  [[nodiscard]] virtual Time Now() const { return Read().now; }

  /// Blocks until the clock shows `due`, jumps or changes its rate, until `sleeper` is woken, or for no reason. Returns
  /// at once if the clock has jumped since `seen`, the reading from which `due` was computed.
  virtual void Wait(Sleeper& sleeper, const ClockReading& seen, Time due) = 0;

  /// Calls `callback` after each jump: on the thread that made the clock jump, before sleeping threads wake up; for the
  /// system's clock on a thread of its own. The callback must not wait for other users of the clock. What it throws
  /// reaches who made the clock jump, after all other callbacks; for the system's and a session's clock it is logged.
  [[nodiscard]] virtual Listening OnJump(JumpCallback callback) = 0;
};

/// Sleeps until `clock` shows `due`: a jump past it ends the sleep, a jump back makes it longer. Returns false if
/// `stop` is requested first.
HGROS_EXPORT bool SleepUntil(Clock& clock, Time due, const std::stop_token& stop = {});

/// Sleeps for `time` on `clock`, ignoring jumps. Returns false if `stop` is requested first.
HGROS_EXPORT bool SleepFor(Clock& clock, Duration time, const std::stop_token& stop = {});

}  // namespace hgros
