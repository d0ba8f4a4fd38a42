#pragma once

#include "hgros/clock/clock.hpp"

namespace hgros {

/// A clock's time at a moment and how it runs from there: everything needed to show the same time elsewhere.
struct ClockState {
  ClockReading reading;  ///< At `source`.
  Time source;           ///< Elapsed time of the clock's source; CLOCK_MONOTONIC for a clock without a source.
  double rate = 1;       ///< Seconds per second of the source.
  bool paused = false;
};

}  // namespace hgros
