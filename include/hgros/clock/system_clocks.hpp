#pragma once

#include <memory>

#include "hgros/base/export.hpp"
#include "hgros/base/log.hpp"
#include "hgros/clock/clock.hpp"

namespace hgros {

/// The system's wall clock in nanoseconds since the Unix epoch. It jumps when it is set and when the machine wakes from
/// suspension; steps below a millisecond are ignored.
///
/// The first wait and the first listener start a thread that watches for jumps and sleeps in between.
/// Errors: OnJump throws Error if the system has no file descriptor or thread left. Waits then read the clock ten times
/// per second until it can be watched; that is logged once.
class HGROS_EXPORT SystemClock final : public Clock {
 public:
  /// Without a `log` it writes to standard error.
  explicit SystemClock(LogSink log = {});
  ~SystemClock() override;

  [[nodiscard]] ClockReading Read() const override;
  [[nodiscard]] Time Now() const override { return WallNow(); }
  void Wait(Sleeper& sleeper, const ClockReading& seen, Time due) override;
  [[nodiscard]] Listening OnJump(JumpCallback callback) override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// CLOCK_MONOTONIC: never jumps. Its start is arbitrary (on Linux, the start of the machine).
class HGROS_EXPORT SteadyClock final : public Clock {
 public:
  [[nodiscard]] ClockReading Read() const override { return {Now(), {}}; }
  [[nodiscard]] Time Now() const override { return {MonotonicNow()}; }
  void Wait(Sleeper& sleeper, const ClockReading& seen, Time due) override;
  [[nodiscard]] Listening OnJump(JumpCallback callback) override;
};

}  // namespace hgros
