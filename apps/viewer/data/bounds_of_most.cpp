#include "viewer/data/bounds_of_most.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace hgros::viewer {
namespace {

constexpr double kOutlier = 10;           // times the usual reach
constexpr double kLargestNumber = 1e100;  // of a coordinate, so that sums stay finite

Eigen::AlignedBox3d Around(const std::vector<Eigen::AlignedBox3d>& boxes) {
  Eigen::AlignedBox3d bounds;
  for (const Eigen::AlignedBox3d& box : boxes) bounds.extend(box);
  return bounds;
}

/// The middle number; of two, the one nearer to 0. Changes the order.
double MedianOf(std::vector<double>& numbers) {
  const auto upper = numbers.begin() + static_cast<std::ptrdiff_t>(numbers.size() / 2);
  std::ranges::nth_element(numbers, upper);
  if (numbers.size() % 2 == 1) return *upper;
  const double lower = *std::max_element(numbers.begin(), upper);
  return std::abs(lower) <= std::abs(*upper) ? lower : *upper;
}

}  // namespace

UsualPlace UsualPlaceOf(const std::vector<Eigen::AlignedBox3d>& boxes, double far_meters) {
  UsualPlace place;
  std::vector<double> numbers(boxes.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::ranges::transform(boxes, numbers.begin(), [axis](const auto& box) { return box.center()[axis]; });
    place.middle[axis] = MedianOf(numbers);
  }
  std::ranges::transform(boxes, numbers.begin(), [&](const auto& box) { return UsualPlace::Reach(place.middle, box); });
  // A quarter is enough to be right: several messages may be malformed.
  const auto usual = numbers.begin() + static_cast<std::ptrdiff_t>((numbers.size() - 1) / 4);
  std::ranges::nth_element(numbers, usual);
  place.reach_meters = std::max(far_meters, kOutlier * *usual);
  return place;
}

Eigen::AlignedBox3d BoundsOfMost(std::vector<Eigen::AlignedBox3d> boxes) {
  std::erase_if(boxes, [](const Eigen::AlignedBox3d& box) {
    const auto is_usual = [](const auto& corner) { return (corner.array().abs() <= kLargestNumber).all(); };
    return box.isEmpty() || !is_usual(box.min()) || !is_usual(box.max());
  });
  const Eigen::AlignedBox3d all = Around(boxes);
  if (boxes.size() < 2 || all.sizes().maxCoeff() <= kFarFromOthersMeters) return all;
  const UsualPlace place = UsualPlaceOf(boxes, kFarFromOthersMeters);
  std::erase_if(boxes, [&](const Eigen::AlignedBox3d& box) { return !place.Has(box); });
  return Around(boxes);
}

}  // namespace hgros::viewer
