#include "viewer/data/shapes/shape_distance.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace hgros::viewer {
namespace {

constexpr Rgba kVisible = MakeRgba(0, 0, 0, 1);

SolidShape Solid(const Eigen::Vector3d& at, const Eigen::Vector3d& size) {
  SolidShape solid;
  solid.pose.leftCols<3>() = size.asDiagonal();
  solid.pose.col(3) = at;
  solid.color = kVisible;
  return solid;
}

TEST(ShapeDistance, IsMeasuredToTheSurface) {
  SceneShapes cube;
  cube.cubes.push_back(Solid({5, 0, 0}, {2, 2, 2}));
  EXPECT_NEAR(DistanceTo(cube, {3, 0, 0}), 1, 1e-9);
  EXPECT_NEAR(DistanceTo(cube, {4, 0.5, 0.5}), 0, 1e-9);
  EXPECT_NEAR(DistanceTo(cube, {5, 0, 0}), 1, 1e-9) << "from inside, too";
  SceneShapes ball;
  ball.spheres.push_back(Solid({0, 0, 0}, {2, 2, 2}));
  EXPECT_NEAR(DistanceTo(ball, {3, 4, 0}), 4, 1e-9);
  SceneShapes cone;
  cone.cylinders.push_back(Solid({0, 0, 0}, {2, 2, 4}));
  cone.cylinders.back().top_scale = 0;
  EXPECT_NEAR(DistanceTo(cone, {0, 0, 2}), 0, 1e-9);
  EXPECT_NEAR(DistanceTo(cone, {0.5, 0, 0}), 0, 1e-9);
  EXPECT_NEAR(DistanceTo(cone, {0, 0, -3}), 1, 1e-9);
  SceneShapes line;
  line.lines.push_back({{0, 0, 0}, {4, 0, 0}, kVisible, 0, 0.2F, false});
  EXPECT_NEAR(DistanceTo(line, {2, 1, 0}), 0.9, 1e-6);
  EXPECT_NEAR(DistanceTo(line, {5, 0, 0}), 0.9, 1e-6);
  SceneShapes triangle;
  for (const Eigen::Vector3d& corner : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(3, 0, 0), Eigen::Vector3d(0, 3, 0)}) {
    triangle.triangles.push_back({corner, kVisible});
  }
  EXPECT_NEAR(DistanceTo(triangle, {1, 1, -2}), 2, 1e-9);
  EXPECT_NEAR(DistanceTo(triangle, {-4, 3, 3}), 5, 1e-9);
}

TEST(ShapeDistance, IsInfiniteWithoutShapes) {
  SceneShapes shapes;
  EXPECT_TRUE(std::isinf(DistanceTo(shapes, {0, 0, 0})));
  shapes.cubes.push_back(Solid({0, 0, 0}, {0, 0, 0}));
  shapes.texts.emplace_back();
  shapes.cubes.push_back(Solid({1, 0, 0}, {1, 1, 1}));
  shapes.cubes.back().color = MakeRgba(255, 0, 0, 0);
  shapes.lines.push_back({{0, 0, 0}, {4, 0, 0}, 0, 0, 1, false});
  shapes.triangles.resize(3, {{1, 1, 1}, 0});
  EXPECT_TRUE(std::isinf(DistanceTo(shapes, {0, 0, 0})));
}

}  // namespace
}  // namespace hgros::viewer
