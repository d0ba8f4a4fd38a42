#pragma once

#include <Eigen/Geometry>
#include <cstddef>
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

/// `points` has a size, and elements of 3 coordinates. What is usual is taken from a sample of them.
template <class Points>
[[nodiscard]] PointBoxes BoxesAround(const Points& points, double far_meters = kFarInMessageMeters) {
  constexpr std::size_t kSample = 1000;
  PointBoxes boxes;
  const auto at = [&](std::size_t i) { return Eigen::Vector3d(points[i].template cast<double>()); };
  for (std::size_t i = 0; i < points.size(); ++i) boxes.all.extend(at(i));
  boxes.most = boxes.all;
  if (boxes.all.isEmpty() || boxes.all.sizes().maxCoeff() <= far_meters) return boxes;
  std::vector<Eigen::AlignedBox3d> sample;
  for (std::size_t i = 0; i < points.size(); i += points.size() / kSample + 1) sample.emplace_back(at(i));
  const UsualPlace place = UsualPlaceOf(sample, far_meters);
  boxes.most.setEmpty();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (place.Has(Eigen::AlignedBox3d(at(i)))) boxes.most.extend(at(i));
  }
  return boxes;
}

}  // namespace hgros::viewer
