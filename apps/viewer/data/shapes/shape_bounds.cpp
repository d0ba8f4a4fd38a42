#include "viewer/data/shapes/shape_bounds.hpp"

#include <vector>

#include "viewer/data/bounds_of_most.hpp"

namespace hgros::viewer {
namespace {

using Boxes = std::vector<Eigen::AlignedBox3d>;

void Add(const std::vector<SolidShape>& solids, Boxes& boxes) {
  for (const SolidShape& solid : solids) {
    const Eigen::Vector3d half = 0.5 * solid.pose.leftCols<3>().cwiseAbs().rowwise().sum();
    boxes.emplace_back(solid.pose.col(3) - half, solid.pose.col(3) + half);
  }
}

}  // namespace

Eigen::AlignedBox3d BoundsOf(const SceneShapes& shapes) {
  Boxes boxes;
  boxes.reserve(shapes.size());
  Add(shapes.cubes, boxes);
  Add(shapes.spheres, boxes);
  Add(shapes.cylinders, boxes);
  for (const LinePiece& line : shapes.lines) {
    boxes.emplace_back(line.from.cwiseMin(line.to), line.from.cwiseMax(line.to));
  }
  for (std::size_t i = 0; i + 2 < shapes.triangles.size(); i += 3) {
    Eigen::AlignedBox3d& box = boxes.emplace_back(shapes.triangles[i].position);
    for (std::size_t k = 1; k < 3; ++k) box.extend(shapes.triangles[i + k].position);
  }
  for (const SceneText& text : shapes.texts) boxes.emplace_back(Eigen::Vector3d(text.pose.col(3)));
  for (const SceneModel& model : shapes.models) boxes.emplace_back(Eigen::Vector3d(model.pose.col(3)));
  return BoundsOfMost(std::move(boxes));
}

}  // namespace hgros::viewer
