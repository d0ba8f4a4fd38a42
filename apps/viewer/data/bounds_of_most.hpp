#pragma once

#include <Eigen/Geometry>
#include <vector>

namespace hgros::viewer {

/// What is farther from everything else is malformed.
inline constexpr double kFarFromOthersMeters = 1e6;

/// The box around all boxes that can be seen together. A box is left out if it is empty, is not made of numbers, or
/// reaches farther from the middle of the others than `far_meters` and than ten times what a quarter of them do. So one
/// malformed message does not make everything else too small to be seen.
[[nodiscard]] Eigen::AlignedBox3d BoundsOfMost(std::vector<Eigen::AlignedBox3d> boxes,
                                               double far_meters = kFarFromOthersMeters);

}  // namespace hgros::viewer
