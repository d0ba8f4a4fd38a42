#pragma once

#include <Eigen/Geometry>
#include <vector>

namespace hgros::viewer {

/// A point or box that is farther than this from the others has malformed coordinates.
inline constexpr double kFarFromOthersMeters = 1e6;

/// The place that most boxes are near: the median of their middles, and how far from it a box may reach.
struct UsualPlace {
  Eigen::Vector3d middle;
  double reach_meters = 0;
  [[nodiscard]] static double Reach(const Eigen::Vector3d& middle, const Eigen::AlignedBox3d& box) {
    return (box.min() - middle).cwiseAbs().cwiseMax((box.max() - middle).cwiseAbs()).maxCoeff();
  }
  [[nodiscard]] bool Has(const Eigen::AlignedBox3d& box) const { return Reach(middle, box) <= reach_meters; }
};

/// Of at least one box. A box may reach as far as `far_meters`, or ten times as far as a quarter of them do.
[[nodiscard]] UsualPlace UsualPlaceOf(const std::vector<Eigen::AlignedBox3d>& boxes, double far_meters);

/// The box around all boxes that can be seen together. A box is left out if it is empty, is not made of numbers, or
/// is not in the UsualPlaceOf all within kFarFromOthersMeters. So one malformed message does not make everything else
/// too small to be seen.
[[nodiscard]] Eigen::AlignedBox3d BoundsOfMost(std::vector<Eigen::AlignedBox3d> boxes);

}  // namespace hgros::viewer
