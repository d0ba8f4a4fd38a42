#pragma once

#include <cstdint>
#include <optional>

#include "hgros/base/export.hpp"
#include "hgros/clock/clock.hpp"

namespace hgros {

/// What happens to moments that pass while their turn does not come, because a callback took too long or a clock was
/// stepped far ahead.
enum class Missed {
  kSkip,     ///< The latest one is taken, the others are counted: no burst.
  kCatchUp,  ///< Each one is taken, late, one right after the other, in the order of their plan.
};

/// One turn of something periodic, or the moment of a timer.
struct Tick {
  Time planned;              ///< What the plan says, without drift; never after `now`.
  Time now;                  ///< What the clock shows.
  std::uint64_t missed = 0;  ///< How many moments before `planned` were left out.
};

/// The moments first, first + period, first + 2 period ..., none of which drifts however late it is taken. When the
/// clock jumps, all of them move along: a rhythm is of elapsed time, so that a jump neither skips, nor repeats, nor
/// delays any.
///
/// Thread safety: none.
class HGROS_EXPORT PeriodicSchedule {
 public:
  /// Takes `seen` for the present. Throws Error unless `period` is above zero.
  PeriodicSchedule(const ClockReading& seen, Time first, Duration period, Missed policy);

  /// The next planned moment, by the clock of the latest reading.
  [[nodiscard]] Time next() const noexcept { return next_; }
  [[nodiscard]] Duration period() const noexcept { return period_; }

  /// Moves along with the jumps since the last reading, then takes the turn that is due, if one is.
  [[nodiscard]] std::optional<Tick> Take(const ClockReading& reading);
  /// Moves along only.
  void Follow(const ClockReading& reading) noexcept;

 private:
  Time next_;
  Duration period_;
  Missed policy_;
  Duration jumped_;
};

}  // namespace hgros
