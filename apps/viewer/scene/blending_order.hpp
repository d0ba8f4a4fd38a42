#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <span>
#include <vector>

namespace hgros::viewer {

/// The order in which transparent displays are drawn: those in front come last. It depends on their bounding boxes
/// only. Boxes that a plane separates are in the right order. If boxes overlap, the one that reaches farther from the
/// eye comes first: a map before the robot on it. Otherwise the order stays.
[[nodiscard]] std::vector<std::size_t> BlendingOrder(std::span<const Eigen::AlignedBox3d> boxes,
                                                     const Eigen::Vector3d& eye);

}  // namespace hgros::viewer
