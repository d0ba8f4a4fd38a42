#include "hgros/clock/following_clock.hpp"

namespace hgros {
namespace {

ClockLine LineOf(const ClockState& state) {
  ClockLine line;
  line.source = state.source;
  line.shown = state.reading.now;
  line.rate = state.rate;
  line.paused = state.paused;
  return line;
}

}  // namespace

void FollowingClock::Follow(const ClockState& state) {
  const Duration jump = state.reading.jumped - followed_jumps_;
  followed_jumps_ = state.reading.jumped;
  Replace(LineOf(state), jump);
}

void FollowingClock::FollowAnother(const ClockState& state) {
  followed_jumps_ = state.reading.jumped;
  Replace(LineOf(state), std::nullopt);
}

void FollowingClock::Pause() {
  ChangePace([](ClockLine& line) { line.paused = true; });
}

}  // namespace hgros
