#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <span>
#include <vector>

#include "hgros/tf/rigid_transform.hpp"

namespace hgros::viewer {

/// The poses of a trajectory as they are drawn: relative to the first one's position, in single precision.
class PoseList {
 public:
  struct Pose {
    Eigen::Vector3f position;
    Eigen::Matrix<float, 4, 1, Eigen::DontAlign> rotation;  ///< Quaternion x, y, z, w; of unit length.
    bool operator==(const Pose&) const = default;
  };
  enum class Change { kNothing, kAppended, kRewritten };

  /// Takes a whole list: most trajectories only grow, and then what is there already need not be drawn again. Poses
  /// that are no numbers are left out and counted.
  Change Replace(std::span<const RigidTransform> poses);
  /// One pose more.
  Change Append(const RigidTransform& pose);
  /// Keeps only the last `count`.
  Change KeepLast(std::size_t count);
  void Clear();

  [[nodiscard]] const std::vector<Pose>& poses() const noexcept { return poses_; }
  [[nodiscard]] const Eigen::Vector3d& origin() const noexcept { return origin_; }
  /// So many KeepLast has taken away, ever.
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
