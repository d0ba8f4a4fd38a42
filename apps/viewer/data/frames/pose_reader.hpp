#pragma once

#include "foxglove/Pose.pb.h"
#include "hgros/tf/rigid_transform.hpp"

namespace hgros::viewer {

/// Reads the pose of a message. An orientation that is not set becomes the identity. Values that are not numbers are
/// kept.
[[nodiscard]] inline RigidTransform ReadPose(const foxglove::Pose& pose) {
  RigidTransform::Rotation turn(pose.orientation().w(), pose.orientation().x(), pose.orientation().y(),
                                pose.orientation().z());
  if (turn.squaredNorm() < 1e-12) turn.setIdentity();
  return {RigidTransform::Rotation(turn.normalized()),
          Eigen::Vector3d(pose.position().x(), pose.position().y(), pose.position().z())};
}

}  // namespace hgros::viewer
