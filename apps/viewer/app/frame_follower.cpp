#include "viewer/app/frame_follower.hpp"

#include <algorithm>
#include <utility>

namespace hgros::viewer {

void FrameFollower::Update(const FixedFrame& frame, const std::string& followed, bool with_rotation) {
  if (std::exchange(name_, followed) != followed) {
    last_.reset();
    camera_is_relative_ = false;
  }
  RigidTransform now;
  std::string why;
  if (name_.empty() || frame.Find(name_, now, why) != FixedFrame::Answer::kFound) return;
  if (last_) {
    camera_.Follow(*last_, now, with_rotation);
  } else if (std::exchange(camera_is_relative_, false)) {
    camera_.Follow(RigidTransform(), now, with_rotation);
  } else {
    camera_.Center(now.translation);  // The frame may be far away from what the camera sees.
  }
  last_ = now;
}

void FrameFollower::Restore(const LayoutCamera& kept, const std::string& followed) {
  const auto& q = kept.orientation;
  if (kept.anchor) camera_.SetAnchor(Eigen::Vector3d(kept.anchor->data()));
  camera_.Place(Eigen::Vector3d(kept.eye.data()), Eigen::Quaterniond(q[3], q[0], q[1], q[2]), kept.distance);
  camera_.SetOrthographic(kept.orthographic);
  name_ = followed;
  camera_is_relative_ = kept.relative && !followed.empty();
}

LayoutCamera FrameFollower::KeptCamera(const std::string& followed, bool with_rotation) const {
  LayoutCamera kept;
  const bool follows = last_ && name_ == followed;
  kept.relative = follows || camera_is_relative_;
  Camera camera = camera_;
  if (follows) camera.Follow(*last_, RigidTransform(), with_rotation);
  std::ranges::copy(camera.eye(), kept.eye.begin());
  std::ranges::copy(camera.orientation().coeffs(), kept.orientation.begin());
  kept.distance = camera.distance();
  kept.orthographic = camera.orthographic();
  if (camera.anchor()) std::ranges::copy(*camera.anchor(), kept.anchor.emplace().begin());
  return kept;
}

}  // namespace hgros::viewer
