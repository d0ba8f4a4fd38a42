#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <span>
#include <vector>

namespace hgros::viewer {

/// The order in which things that can be seen through are drawn, so that what is in front comes last; as far as their
/// boxes tell. Boxes that a plane separates are in the right order. Of boxes that overlap the one that reaches farther
/// from the eye comes first: a map before the robot on it. Otherwise their order stays.
[[nodiscard]] std::vector<std::size_t> BlendingOrder(std::span<const Eigen::AlignedBox3d> boxes,
                                                     const Eigen::Vector3d& eye);

}  // namespace hgros::viewer
