#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

namespace hgros::viewer {

/// Counts the pictures that still have to be drawn and those that were drawn, and says when the next one may be drawn.
/// Times are seconds on the monotonic clock.
class FramePace {
 public:
  void SetLimit(double pictures_per_second) { limit_ = pictures_per_second; }
  [[nodiscard]] double limit() const noexcept { return limit_; }

  /// Wants at least one more picture.
  void WantOne() { wanted_ = std::max(wanted_, 1); }
  /// Wants some more pictures: after input, ImGui needs several until nothing moves.
  void WantAfterInput() { wanted_ = kAfterInput; }
  [[nodiscard]] bool wanted() const noexcept { return wanted_ > 0; }
  void CountDownWanted() { wanted_ = std::max(wanted_ - 1, 0); }

  void BeginTurn(double now_s) { last_turn_s_ = now_s; }
  [[nodiscard]] double last_turn_s() const noexcept { return last_turn_s_; }
  /// When the limit allows the next turn.
  [[nodiscard]] double soonest_turn_s() const { return last_turn_s_ + 1 / limit_; }

  void BeginFrame(double now_s);
  void EndFrame(double now_s);
  /// When the status line has to show that nothing is drawn any more.
  [[nodiscard]] double idle_s() const noexcept { return idle_s_; }
  /// Pictures of the last second.
  [[nodiscard]] std::size_t frames_per_second() const noexcept { return recent_s_.size(); }
  /// All pictures so far.
  [[nodiscard]] std::size_t frames() const noexcept { return frames_; }

 private:
  static constexpr double kNever = std::numeric_limits<double>::infinity();
  static constexpr int kAfterInput = 3;

  double limit_ = 30;
  int wanted_ = kAfterInput;
  double last_turn_s_ = -kNever;
  double idle_s_ = kNever;
  std::size_t frames_ = 0;
  std::vector<double> recent_s_;
};

}  // namespace hgros::viewer
