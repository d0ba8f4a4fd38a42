#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "hgros/base/export.hpp"
#include "hgros/clock/clock.hpp"
#include "hgros/internal/clock/clock_line.hpp"
#include "hgros/internal/clock/clock_state.hpp"
#include "hgros/internal/clock/waiting_room.hpp"

namespace hgros {

/// A clock that runs along another clock, its source. It follows the source's elapsed time but not its jumps.
class HGROS_EXPORT DerivedClock : public Clock {
 public:
  [[nodiscard]] ClockReading Read() const override;
  void Wait(Sleeper& sleeper, const ClockReading& seen, Time due) override;
  [[nodiscard]] Listening OnJump(JumpCallback callback) override;

  [[nodiscard]] ClockState State() const;
  /// Calls `callback` after each jump and each change of rate, on the thread that makes it. State() returns the new
  /// state.
  [[nodiscard]] Listening OnChange(std::function<void()> callback);

 protected:
  /// Shows `start` now. Without a source it uses a SteadyClock.
  DerivedClock(Time start, std::shared_ptr<Clock> source, bool paused = false);

  /// Changes how the clock runs from now on, then wakes waiting threads. `change` gets the line anchored at this
  /// moment.
  void ChangePace(const std::function<void(ClockLine&)>& change);
  /// Makes the clock show `after`, tells the listeners, then wakes waiting threads.
  void Jump(Time after);
  /// Runs along `line` from now on. `jump` is the part of the difference to the current time that counts as a jump;
  /// without it, all of it does. The rest is time that passes; if it is negative the clock stands still for that long.
  void Replace(ClockLine line, std::optional<Duration> jump);
  [[nodiscard]] ClockLine line() const;

 private:
  struct Changed {};
  void TellChange(const ClockJump* jump);

  const std::shared_ptr<Clock> source_;
  mutable std::mutex mutex_;
  ClockLine line_;      // guarded by mutex_
  Duration jumped_{0};  // guarded by mutex_
  Listeners<ClockJump> listeners_;
  Listeners<Changed> changes_;
  WaitingRoom waiting_;
};

/// Time since a reference: b plus the time elapsed since SetBaseTime(b), or since the clock was created, with b = 0.
class HGROS_EXPORT RelativeClock final : public DerivedClock {
 public:
  explicit RelativeClock(std::shared_ptr<Clock> source = nullptr) : DerivedClock({}, std::move(source)) {}

  /// Makes this moment the reference, at which the clock shows `base`: a jump.
  void SetBaseTime(Duration base) { Jump(Time{base.count()}); }
};

/// The time of a simulation or a recording. Starts at `start` and runs at rate 1 until one of the functions below
/// changes that.
///
/// Errors: throws Error for a rate that is not positive or above a million, and for a step back.
class HGROS_EXPORT SimulatedClock final : public DerivedClock {
 public:
  explicit SimulatedClock(Time start = {}, std::shared_ptr<Clock> source = nullptr)
      : DerivedClock(start, std::move(source)) {}
  /// A clock that is paused at `start`: only Step() advances it until it is resumed.
  [[nodiscard]] static std::shared_ptr<SimulatedClock> Paused(Time start = {}) {
    return std::shared_ptr<SimulatedClock>(new SimulatedClock(start, true));
  }

  static constexpr double kMostRate = 1e6;  ///< A clock that runs out of its range cannot be followed.
  /// Seconds of this clock per second of its source. A pause does not change it.
  void SetRate(double rate);
  [[nodiscard]] double rate() const { return line().rate; }

  void Pause();
  void Resume();
  [[nodiscard]] bool paused() const { return line().paused; }

  /// Lets `time` pass at once, paused or not: everything planned within it becomes due, in order. Not a jump.
  void Step(Duration time);
  /// Shows `to` from now on. Timers planned by elapsed time move along; timers planned for a moment run when the clock
  /// shows it.
  void JumpTo(Time to) { Jump(to); }

 private:
  SimulatedClock(Time start, bool paused) : DerivedClock(start, nullptr, paused) {}
};

}  // namespace hgros
