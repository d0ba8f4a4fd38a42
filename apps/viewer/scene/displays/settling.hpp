#pragma once

#include <limits>

#include "viewer/scene/display.hpp"

namespace hgros::viewer {

/// The layer of something that is replaced as a whole. The first one is settled, as if it stayed. When it is replaced,
/// it moves until it has not changed for a while.
class Settling {
 public:
  /// Call it when it was replaced or has moved. Returns what must be drawn.
  [[nodiscard]] Change Replaced(double now_s) {
    replaced_s_ = now_s;
    is_drawn_ = false;
    if (!is_there_) {
      is_there_ = true;
      return Change::kAppended;
    }
    if (moves_) return Change::kMoving;
    moves_ = true;
    return Change::kRedraw;
  }
  /// Settles it if it has not changed for a while. Returns what must be drawn.
  [[nodiscard]] Change Rest(double now_s) {
    if (!moves_ || now_s - replaced_s_ < kRestS) return Change::kNothing;
    moves_ = false;
    return Change::kAppended;
  }
  /// Call it when it is removed. Returns what must be drawn.
  [[nodiscard]] Change Gone() {
    const bool was_settled = is_there_ && !moves_;
    is_there_ = moves_ = is_drawn_ = false;
    return was_settled ? Change::kRedraw : Change::kMoving;
  }

  /// Returns whether DrawNew has to draw it, and assumes that it does.
  [[nodiscard]] bool TakeNew() {
    if (!is_there_ || moves_ || is_drawn_) return false;
    is_drawn_ = true;
    return true;
  }
  /// Returns whether DrawSettled has to draw it, and assumes that it does.
  [[nodiscard]] bool TakeSettled() {
    is_drawn_ = is_there_ && !moves_;
    return is_drawn_;
  }
  [[nodiscard]] bool moves() const noexcept { return moves_; }
  [[nodiscard]] bool settled() const noexcept { return is_there_ && !moves_; }
  [[nodiscard]] double next_change_s() const noexcept {
    return moves_ ? replaced_s_ + kRestS : std::numeric_limits<double>::infinity();
  }

 private:
  static constexpr double kRestS = 2;

  bool is_there_ = false;
  bool moves_ = false;
  bool is_drawn_ = false;  ///< It is in the settled layer.
  double replaced_s_ = 0;
};

}  // namespace hgros::viewer
