#include "viewer/data/shapes/shape_bounds.hpp"

namespace hgros::viewer {
namespace {

void ExtendBy(const std::vector<SolidShape>& solids, Eigen::AlignedBox3d& bounds) {
  for (const SolidShape& solid : solids) {
    const Eigen::Vector3d half = 0.5 * solid.pose.leftCols<3>().cwiseAbs().rowwise().sum();
    bounds.extend(solid.pose.col(3) - half);
    bounds.extend(solid.pose.col(3) + half);
  }
}

}  // namespace

Eigen::AlignedBox3d BoundsOf(const SceneShapes& shapes) {
  Eigen::AlignedBox3d bounds;
  ExtendBy(shapes.cubes, bounds);
  ExtendBy(shapes.spheres, bounds);
  ExtendBy(shapes.cylinders, bounds);
  for (const LinePiece& line : shapes.lines) {
    bounds.extend(line.from);
    bounds.extend(line.to);
  }
  for (const TriangleCorner& corner : shapes.triangles) bounds.extend(corner.position);
  for (const SceneText& text : shapes.texts) bounds.extend(Eigen::Vector3d(text.pose.col(3)));
  for (const SceneModel& model : shapes.models) bounds.extend(Eigen::Vector3d(model.pose.col(3)));
  return bounds;
}

}  // namespace hgros::viewer
