#pragma once

#include <functional>
#include <stop_token>

#include "hgros/base/export.hpp"
#include "hgros/base/listeners.hpp"
#include "hgros/clock/sleeper.hpp"
#include "hgros/clock/time.hpp"

namespace hgros {

/// What a clock shows, and how much of that it owes to jumps: `now - jumped` runs on without any.
struct ClockReading {
  Time now;
  Duration jumped{0};  ///< The sum of all jumps so far, those back being negative.

  [[nodiscard]] Time elapsed() const noexcept { return now - jumped; }
};

/// A clock was set: instead of `before` it shows `after`.
struct ClockJump {
  Time before;
  Time after;
};
using JumpCallback = std::function<void(const ClockJump&)>;

/// What shows the time: the system's, a steady one, one that begins at a reference, a simulated one. Whatever waits,
/// waits on one of these, and follows it when it jumps, pauses or changes its rate.
///
/// Contract, for every clock:
///  1. Between jumps it never goes back.
///  2. A wait that sees its moment come returns; so does one during which the clock jumps or changes its pace. Who
///  waits
///     looks at the clock again and decides.
///  3. No jump is lost between a reading and a wait that is given this reading.
///  4. A listener hears of every jump, after which the clock shows the new time to everybody.
///
/// Thread safety: all of it.
class HGROS_EXPORT Clock {
 public:
  Clock() = default;
  Clock(const Clock&) = delete;
  Clock& operator=(const Clock&) = delete;
  virtual ~Clock() = default;

  [[nodiscard]] virtual ClockReading Read() const = 0;
  [[nodiscard]] virtual Time Now() const { return Read().now; }

  /// Blocks until the clock shows `due`, until it jumps or changes its pace, until `sleeper` is woken, or for no
  /// reason. Returns at once if it has jumped since `seen`, from which `due` was worked out.
  virtual void Wait(Sleeper& sleeper, const ClockReading& seen, Time due) = 0;

  /// Calls `callback` after each jump: on the thread that made the clock jump, before those who sleep wake up; of the
  /// system's clock on a thread of its own. It must not wait for others who use the clock.
  [[nodiscard]] virtual Listening OnJump(JumpCallback callback) = 0;
};

/// Sleeps until `clock` shows `due`: a jump beyond it ends the sleep, a jump back makes it longer. Returns false if
/// `stop` is requested first.
HGROS_EXPORT bool SleepUntil(Clock& clock, Time due, const std::stop_token& stop = {});

/// Sleeps for `time` of `clock`, in which jumps do not count. Returns false if `stop` is requested first.
HGROS_EXPORT bool SleepFor(Clock& clock, Duration time, const std::stop_token& stop = {});

}  // namespace hgros
