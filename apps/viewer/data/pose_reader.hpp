#pragma once

#include "foxglove/Pose.pb.h"
#include "hgros/tf/rigid_transform.hpp"

namespace hgros::viewer {

/// A pose of a message. An orientation that is not set is none; what is no number stays so.
[[nodiscard]] inline RigidTransform ReadPose(const foxglove::Pose& pose) {
  RigidTransform::Rotation turn(pose.orientation().w(), pose.orientation().x(), pose.orientation().y(),
                                pose.orientation().z());
  if (turn.squaredNorm() < 1e-12) turn.setIdentity();
  return {RigidTransform::Rotation(turn.normalized()),
          Eigen::Vector3d(pose.position().x(), pose.position().y(), pose.position().z())};
}

}  // namespace hgros::viewer
