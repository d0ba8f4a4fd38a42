#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>

#include "hgros/tf/rigid_transform.hpp"

namespace hgros::viewer {

/// The points of a message in the fixed frame, in meters. Each point is transformed when it is read, so this needs no
/// memory. The message's points must outlive it.
class PlacedPoints {
 public:
  PlacedPoints(std::span<const Eigen::Vector3f> points, const RigidTransform& T_fixed_points)
      : points_(points), turn_(T_fixed_points.rotation.toRotationMatrix()), shift_(T_fixed_points.translation) {}

  [[nodiscard]] std::size_t size() const noexcept { return points_.size(); }
  [[nodiscard]] bool empty() const noexcept { return points_.empty(); }
  [[nodiscard]] Eigen::Vector3d operator[](std::size_t i) const { return turn_ * points_[i].cast<double>() + shift_; }

 private:
  std::span<const Eigen::Vector3f> points_;
  Eigen::Matrix3d turn_;
  Eigen::Vector3d shift_;
};

}  // namespace hgros::viewer
