#pragma once

#include <urdf_model/pose.h>

#include <Eigen/Geometry>

namespace hgros::viewer {

/// Reads a pose of a URDF. An invalid rotation becomes the identity.
[[nodiscard]] inline Eigen::Isometry3d RobotPose(const urdf::Pose& pose) {
  Eigen::Isometry3d isometry = Eigen::Isometry3d::Identity();
  const Eigen::Quaterniond rotation(pose.rotation.w, pose.rotation.x, pose.rotation.y, pose.rotation.z);
  if (rotation.norm() > 1e-9) isometry.linear() = rotation.normalized().toRotationMatrix();
  isometry.translation() = Eigen::Vector3d(pose.position.x, pose.position.y, pose.position.z);
  return isometry;
}

}  // namespace hgros::viewer
