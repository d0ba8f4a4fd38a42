#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <utility>
#include <vector>

#include "viewer/data/bounds_of_most.hpp"

namespace hgros::viewer {

/// Points of a message that are farther than this from its other points, and ten times as far as usual, are outliers.
inline constexpr double kFarInMessageMeters = 1000;

/// The boxes around the points of a message.
struct PointBoxes {
  Eigen::AlignedBox3d all;
  Eigen::AlignedBox3d most;  ///< Without outliers.
};

/// `points` has a size, and elements of 3 coordinates.
template <class Points>
[[nodiscard]] PointBoxes BoxesAround(const Points& points) {
  PointBoxes boxes;
  const auto at = [&](std::size_t i) { return Eigen::Vector3d(points[i].template cast<double>()); };
  for (std::size_t i = 0; i < points.size(); ++i) boxes.all.extend(at(i));
  boxes.most = boxes.all;
  if (boxes.all.isEmpty() || boxes.all.sizes().maxCoeff() <= kFarInMessageMeters) return boxes;
  std::vector<Eigen::AlignedBox3d> each;
  each.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) each.emplace_back(at(i));
  boxes.most = BoundsOfMost(std::move(each), kFarInMessageMeters);
  return boxes;
}

}  // namespace hgros::viewer
