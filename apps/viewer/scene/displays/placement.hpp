#pragma once

#include <string>

#include "hgros/tf/rigid_transform.hpp"
#include "viewer/scene/display.hpp"
#include "viewer/scene/displays/transform_wait.hpp"

namespace hgros::viewer {

/// The latest place of a frame, updated as transforms arrive.
class Placement {
 public:
  /// Returns whether the frame has moved since the last call, or its place has become known. Without a newer transform,
  /// the last known place stays.
  [[nodiscard]] bool Follow(const std::string& frame, const UpdateContext& context);
  /// The place must be looked up again, and a missing transform is waited for again.
  void Forget() {
    known_ = false;
    wait_ = {};
  }

  [[nodiscard]] bool known() const noexcept { return known_; }
  [[nodiscard]] const RigidTransform& T_fixed_frame() const noexcept { return placed_; }
  /// Why there has been no newer place for a while, as a sentence. Empty if there is one, or may still come.
  [[nodiscard]] std::string fault() const { return wait_.fault(); }
  /// Display::WaitsFor and Display::next_change_s.
  [[nodiscard]] std::string waits_for() const { return wait_.waits_for(); }
  [[nodiscard]] double next_change_s() const { return wait_.next_change_s(); }

 private:
  std::string frame_;
  RigidTransform placed_;
  TransformWait wait_;
  bool known_ = false;
};

}  // namespace hgros::viewer
