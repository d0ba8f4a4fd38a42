#pragma once

#include <memory>
#include <utility>

#include "hgros/base/export.hpp"
#include "hgros/clock/derived_clocks.hpp"
#include "hgros/internal/clock/clock_state.hpp"

namespace hgros {

/// Shows the time of a simulated clock elsewhere, from states that arrive now and then. In between it runs by itself at
/// the last known rate, so that sleeping threads need no message to wake up. Paused at 0 until the first state.
///
/// A jump of the other clock is a jump here; every other difference is time that passed. If this clock has run ahead
/// because it learned about a pause late, it stands still until the other clock has caught up.
///
/// Thread safety: as Clock; one state is set at a time, and not from its listeners.
class HGROS_EXPORT FollowingClock final : public DerivedClock {
 public:
  explicit FollowingClock(std::shared_ptr<Clock> source = nullptr) : DerivedClock({}, std::move(source), true) {}

  /// A new state of the clock that is being followed; `state.source` is a time of this clock's own source.
  void Follow(const ClockState& state);
  /// Follows another clock from now on: the difference is a jump.
  void FollowAnother(const ClockState& state);
  /// Stands still until the next state.
  void Pause();

 private:
  // Jumps of the followed clock so far.
  Duration followed_jumps_{0};
};

}  // namespace hgros
