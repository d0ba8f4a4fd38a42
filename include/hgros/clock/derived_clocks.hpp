#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "hgros/base/export.hpp"
#include "hgros/clock/clock.hpp"
#include "hgros/clock/clock_line.hpp"
#include "hgros/clock/clock_state.hpp"
#include "hgros/clock/waiting_room.hpp"

namespace hgros {

/// A clock that runs along another one, its source, of which it takes the time that elapses, but not the jumps.
class HGROS_EXPORT DerivedClock : public Clock {
 public:
  [[nodiscard]] ClockReading Read() const override;
  void Wait(Sleeper& sleeper, const ClockReading& seen, Time due) override;
  [[nodiscard]] Listening OnJump(JumpCallback callback) override;

  [[nodiscard]] ClockState State() const;
  /// Calls `callback` after each jump and each change of pace, on the thread that makes it. State() says what it is
  /// now.
  [[nodiscard]] Listening OnChange(std::function<void()> callback);

 protected:
  /// Shows `start` now. Without a source it takes a SteadyClock.
  DerivedClock(Time start, std::shared_ptr<Clock> source, bool paused = false);

  /// Changes how the clock runs from now on, then wakes whoever waits. `change` gets the line anchored at this moment.
  void ChangePace(const std::function<void(ClockLine&)>& change);
  /// Makes the clock show `after`, tells the listeners, then wakes whoever waits.
  void Jump(Time after);
  /// Runs along `line` from now on. Of what this differs from what is shown now, `jump` is one, or all of it without a
  /// `jump`; the rest is time that passed, and if it is less than none the clock stands still for so long.
  void Replace(ClockLine line, std::optional<Duration> jump);
  [[nodiscard]] ClockLine line() const;

 private:
  struct Changed {};

  const std::shared_ptr<Clock> source_;
  mutable std::mutex mutex_;
  ClockLine line_;      // guarded by mutex_
  Duration jumped_{0};  // guarded by mutex_
  Listeners<ClockJump> listeners_;
  Listeners<Changed> changes_;
  WaitingRoom waiting_;
};

/// Time since a reference: b + what has elapsed since SetBaseTime(b) was called, or since the clock was made, with b =
/// 0.
class HGROS_EXPORT RelativeClock final : public DerivedClock {
 public:
  explicit RelativeClock(std::shared_ptr<Clock> source = nullptr) : DerivedClock({}, std::move(source)) {}

  /// The reference is now, and the clock shows `base`: a jump.
  void SetBaseTime(Duration base) { Jump(Time{base.count()}); }
};

/// Time as a simulation or a recording wants it. Runs from `start` at rate 1 until told otherwise.
///
/// Errors: throws Error for a rate that is not above zero and finite, and for a step back.
class HGROS_EXPORT SimulatedClock final : public DerivedClock {
 public:
  explicit SimulatedClock(Time start = {}, std::shared_ptr<Clock> source = nullptr)
      : DerivedClock(start, std::move(source)) {}
  /// One that is paused at `start`: it goes on by Step() alone until it is resumed.
  [[nodiscard]] static std::shared_ptr<SimulatedClock> Paused(Time start = {}) {
    return std::shared_ptr<SimulatedClock>(new SimulatedClock(start, true));
  }

  /// Seconds of this clock for one of its source. Holds after a pause, too.
  void SetRate(double rate);
  [[nodiscard]] double rate() const { return line().rate; }

  void Pause();
  void Resume();
  [[nodiscard]] bool paused() const { return line().paused; }

  /// Lets `time` pass at once, paused or not: what is planned in it comes due, in its order. No jump.
  void Step(Duration time);
  /// Shows `to` from now on. What was planned by the time that passes moves along; what was planned for a moment comes
  /// when the clock shows it.
  void JumpTo(Time to) { Jump(to); }

 private:
  SimulatedClock(Time start, bool paused) : DerivedClock(start, nullptr, paused) {}
};

}  // namespace hgros
