#pragma once

#include <string>

#include "hgros/tf/rigid_transform.hpp"
#include "viewer/scene/display.hpp"

namespace hgros::viewer {

/// Where the frame of what is shown lies now: by its latest transform, followed as transforms come.
class Placement {
 public:
  /// Whether the frame lies elsewhere than at the last call, or its place has become known. It stays where it was last
  /// known to be.
  [[nodiscard]] bool Follow(const std::string& frame, const UpdateContext& context);
  /// It is to be looked up anew.
  void Forget() { known_ = false; }

  [[nodiscard]] bool known() const noexcept { return known_; }
  [[nodiscard]] const RigidTransform& T_fixed_frame() const noexcept { return placed_; }
  /// Why there is no newer place, in a sentence; empty if there is one.
  [[nodiscard]] const std::string& fault() const noexcept { return fault_; }

 private:
  std::string frame_;
  RigidTransform placed_;
  std::string fault_;
  bool known_ = false;
};

}  // namespace hgros::viewer
