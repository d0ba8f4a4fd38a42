#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <span>
#include <vector>

#include "hgros/tf/rigid_transform.hpp"

namespace hgros::viewer {

/// The poses of a trajectory as they are drawn: relative to the first position, in single precision.
class PoseList {
 public:
  struct Pose {
    Eigen::Vector3f position;
    Eigen::Matrix<float, 4, 1, Eigen::DontAlign> rotation;  ///< Unit quaternion x, y, z, w.
    bool operator==(const Pose&) const = default;
  };
  enum class Change { kNothing, kAppended, kRewritten };

  /// Replaces the whole list. Most trajectories only grow, so poses that are already there are not drawn again. Poses
  /// that are not numbers are left out and counted.
  Change Replace(std::span<const RigidTransform> poses);
  /// Appends one pose.
  Change Append(const RigidTransform& pose);
  /// Keeps only the last `count`.
  Change KeepLast(std::size_t count);
  void Clear();

  [[nodiscard]] const std::vector<Pose>& poses() const noexcept { return poses_; }
  [[nodiscard]] const Eigen::Vector3d& origin() const noexcept { return origin_; }
  /// Number of poses that KeepLast has removed since the start.
  [[nodiscard]] std::size_t removed() const noexcept { return removed_; }
  [[nodiscard]] std::size_t left_out() const noexcept { return left_out_; }

 private:
  [[nodiscard]] Pose Drawn(const RigidTransform& pose) const;

  std::vector<Pose> poses_;
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  std::size_t removed_ = 0;
  std::size_t left_out_ = 0;
};

}  // namespace hgros::viewer
