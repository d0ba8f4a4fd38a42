#pragma once

#include <string>

#include "hgros/tf/rigid_transform.hpp"
#include "viewer/scene/display.hpp"

namespace hgros::viewer {

/// The latest place of a frame, updated as transforms arrive.
class Placement {
 public:
  /// Returns whether the frame has moved since the last call, or its place has become known. Without a newer transform,
  /// the last known place stays.
  [[nodiscard]] bool Follow(const std::string& frame, const UpdateContext& context);
  /// The place must be looked up again.
  void Forget() { known_ = false; }

  [[nodiscard]] bool known() const noexcept { return known_; }
  [[nodiscard]] const RigidTransform& T_fixed_frame() const noexcept { return placed_; }
  /// Why there is no newer place, as a sentence. Empty if there is one.
  [[nodiscard]] const std::string& fault() const noexcept { return fault_; }

 private:
  std::string frame_;
  RigidTransform placed_;
  std::string fault_;
  bool known_ = false;
};

}  // namespace hgros::viewer
