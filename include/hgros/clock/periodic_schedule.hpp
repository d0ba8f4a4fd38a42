#pragma once

#include <cstdint>
#include <optional>

#include "hgros/base/export.hpp"
#include "hgros/clock/clock.hpp"

namespace hgros {

/// The policy for planned moments that were missed because a callback took too long or the clock was stepped ahead.
enum class Missed {
  kSkip,     ///< Only the latest one is run, the others are counted: no burst.
  kCatchUp,  ///< Each one is run late, one right after the other, in order.
};

/// One turn of a periodic timer, or the moment of a single one.
struct Tick {
  Time planned;              ///< The planned moment, without drift; never after `now`.
  Time now;                  ///< The clock's time.
  std::uint64_t missed = 0;  ///< Number of moments before `planned` that were skipped.
};

/// The moments first, first + period, first + 2 period ..., without drift, however late each one is run. The schedule
/// follows elapsed time: when the clock jumps, all planned moments move along, so a jump neither skips nor repeats nor
/// delays a turn.
///
/// Thread safety: none; the owner guards it.
class HGROS_EXPORT PeriodicSchedule {
 public:
  /// Starts at `seen`. Throws Error unless `period` is positive.
  PeriodicSchedule(const ClockReading& seen, Time first, Duration period, Missed policy);

  /// The next planned moment, on the clock of the latest reading.
  [[nodiscard]] Time next() const noexcept { return next_; }
  [[nodiscard]] Duration period() const noexcept { return period_; }

  /// Follows the jumps since the last reading, then returns the turn that is due, if there is one, and plans the next.
  [[nodiscard]] std::optional<Tick> AdvanceTo(const ClockReading& reading);
  /// Follows the jumps only.
  void Follow(const ClockReading& reading) noexcept;

 private:
  Time next_;
  Duration period_;
  Missed policy_;
  Duration jumped_;
};

}  // namespace hgros
