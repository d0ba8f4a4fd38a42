#pragma once

#include <optional>
#include <string>

#include "hgros/tf/rigid_transform.hpp"
#include "viewer/app/layout/layout.hpp"
#include "viewer/data/frames/fixed_frame.hpp"
#include "viewer/view/camera.hpp"

namespace hgros::viewer {

/// Moves the camera along with a frame.
class FrameFollower {
 public:
  explicit FrameFollower(Camera& camera) : camera_(camera) {}

  /// Whether the frame has not been found yet: a message may still name it.
  [[nodiscard]] bool searches(const std::string& followed) const { return !last_ || name_ != followed; }
  /// Moves the camera to where the frame is now. Empty: none is followed.
  void Update(const FixedFrame& frame, const std::string& followed, bool with_rotation);

  /// Places the camera as a layout has it.
  void Restore(const LayoutCamera& kept, const std::string& followed);
  /// The camera for a layout: seen from the frame while one is followed.
  [[nodiscard]] LayoutCamera KeptCamera(const std::string& followed, bool with_rotation) const;

 private:
  Camera& camera_;
  std::string name_;
  std::optional<RigidTransform> last_;  ///< Where the frame was last.
  bool camera_is_relative_ = false;     ///< The camera is placed as seen from the frame, which is not found yet.
};

}  // namespace hgros::viewer
