#pragma once

#include "hgros/clock/clock.hpp"
#include "hgros/clock/time.hpp"

namespace hgros {

// Detects jumps of the wall clock by comparing it with a steady clock. Both are slewed in the same way, so only a jump
// changes their difference.
//
// Thread safety: none.
class WallOffset {
 public:
  // Smaller steps are noise: the two clocks are read one after the other.
  static constexpr Duration kLeastJump = std::chrono::milliseconds(1);

  WallOffset(Time wall, Time steady) : offset_(wall - steady) {}

  ClockReading Correct(Time wall, Time steady) {
    const Duration change = (wall - steady) - offset_;
    if (change >= kLeastJump || change <= -kLeastJump) {
      offset_ += change;
      jumped_ += change;
    }
    return {wall, jumped_};
  }

 private:
  Duration offset_;
  Duration jumped_{0};
};

}  // namespace hgros
