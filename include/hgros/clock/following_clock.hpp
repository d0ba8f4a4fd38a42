#pragma once

#include <memory>
#include <utility>

#include "hgros/base/export.hpp"
#include "hgros/clock/clock_state.hpp"
#include "hgros/clock/derived_clocks.hpp"

namespace hgros {

/// Shows what a simulated clock elsewhere shows, from what is told of it now and then. In between it runs on by itself
/// at the last known pace, so whoever sleeps on it needs no message to wake up. Paused at 0 until it is told something.
///
/// What is told of a jump is a jump here; whatever else is told is time that passed. If this clock has run ahead, since
/// it heard of a pause late, it stands still until the other one has come as far.
///
/// Thread safety: as Clock; who tells it does so one call at a time, and not from its listeners.
class HGROS_EXPORT FollowingClock final : public DerivedClock {
 public:
  explicit FollowingClock(std::shared_ptr<Clock> source = nullptr) : DerivedClock({}, std::move(source), true) {}

  /// What is told of the clock that this one follows already; `state.source` is of this clock's own source.
  void Follow(const ClockState& state);
  /// From now on it follows another clock: what they differ by is a jump.
  void FollowAnother(const ClockState& state);
  /// Stands still until it is told something.
  void Pause();

 private:
  // Jumps of the clock that is followed, so far.
  Duration followed_jumps_{0};
};

}  // namespace hgros
