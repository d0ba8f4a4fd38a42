#pragma once

#include <cstdint>
#include <limits>

#include "hgros/base/export.hpp"
#include "hgros/clock/time.hpp"

namespace hgros {

/// How a clock runs along the elapsed time of another clock: it shows `shown` at `source` and continues at `rate`.
///
/// Exact for rate 1. Other rates are rounded down, by less than 1 ns however long it runs (for 104 days on machines
/// whose long double has no more bits than a double).
struct HGROS_EXPORT ClockLine {
  Time source;
  Time shown;
  double rate = 1.0;
  bool paused = false;
  Time least = {
      std::numeric_limits<std::int64_t>::min()};  ///< Lower bound: the clock stands still until it has passed this.

  [[nodiscard]] Time At(Time source_now) const noexcept;
  /// The first moment of the source at which the clock shows `due` or later; Time::Never() while it is paused.
  [[nodiscard]] Time SourceOf(Time due) const noexcept;
};

}  // namespace hgros
