#pragma once

#include "hgros/clock/clock.hpp"

namespace hgros {

/// How a clock stands at a moment, and how it runs from there: all that somebody has to know who shows the same.
struct ClockState {
  ClockReading reading;  ///< At `source`.
  Time source;           ///< Elapsed time of the clock's source; of one without a source of its own, CLOCK_MONOTONIC.
  double rate = 1;       ///< Seconds for one of the source.
  bool paused = false;
};

}  // namespace hgros
