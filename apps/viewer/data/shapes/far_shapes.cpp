#include "viewer/data/shapes/far_shapes.hpp"

#include <algorithm>

namespace hgros::viewer {
namespace {

/// Also false for values that are not numbers.
template <class Numbers>
bool IsNear(const Numbers& numbers) {
  return (numbers.array().abs() <= kFarthestMeters).all();
}

template <class Shape>
std::size_t LeaveOutFar(std::vector<Shape>& shapes) {
  return std::erase_if(shapes, [](const Shape& shape) { return !IsNear(shape.pose); });
}

/// Whole triangles only.
std::size_t LeaveOutFarOnes(std::vector<TriangleCorner>& corners) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
    if (!IsNear(corners[i].position) || !IsNear(corners[i + 1].position) || !IsNear(corners[i + 2].position)) continue;
    for (std::size_t k = 0; k < 3; ++k) corners[kept++] = corners[i + k];
  }
  const std::size_t far = (corners.size() - kept) / 3;
  corners.resize(kept);
  return far;
}

}  // namespace

std::size_t LeaveOutFar(SceneShapes& shapes) {
  return LeaveOutFar(shapes.cubes) + LeaveOutFar(shapes.spheres) + LeaveOutFar(shapes.cylinders) +
         LeaveOutFar(shapes.texts) + LeaveOutFar(shapes.models) + LeaveOutFarOnes(shapes.triangles) +
         std::erase_if(shapes.lines, [](const LinePiece& line) { return !IsNear(line.from) || !IsNear(line.to); });
}

}  // namespace hgros::viewer
