#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "viewer/data/shapes/far_shapes.hpp"
#include "viewer/data/shapes/shape_bounds.hpp"
#include "viewer/data/shapes/shape_distance.hpp"

namespace hgros::viewer {
namespace {

using Pose = Eigen::Matrix<double, 3, 4>;
using Eigen::Vector3d;

Pose CubePoseAt(double x) {
  Pose pose = Pose::Identity();
  pose(0, 3) = x;
  return pose;
}

TEST(FarShapes, AreRemovedForEveryKindAndTheOthersStay) {
  for (const double far : {9e307, -2e9, std::numeric_limits<double>::infinity(), std::nan("")}) {
    SceneShapes shapes;
    for (const double x : {1.0, far, -9e8}) {
      shapes.cubes.push_back({CubePoseAt(x)});
      shapes.spheres.push_back({CubePoseAt(x)});
      shapes.cylinders.push_back({CubePoseAt(x)});
      shapes.texts.push_back({CubePoseAt(x), "text"});
      shapes.models.push_back({CubePoseAt(x), "url", {}, {}});
      shapes.lines.push_back({Vector3d(0, x, 0), Vector3d::Zero()});
      for (int i = 0; i < 3; ++i) shapes.triangles.push_back({Vector3d(0, 0, i == 1 ? x : 0)});
    }
    EXPECT_EQ(LeaveOutFar(shapes), 7U) << far;
    EXPECT_EQ(shapes.size(), 14U);
    EXPECT_EQ(shapes.triangles.size(), 6U);
    EXPECT_EQ(shapes.triangles[4].position.z(), -9e8);
    EXPECT_EQ(LeaveOutFar(shapes), 0U);
  }
}

TEST(FarShapes, IncludeShapesThatAreTooLarge) {
  SceneShapes shapes;
  shapes.cubes.push_back({1e300 * CubePoseAt(0)});
  EXPECT_EQ(LeaveOutFar(shapes), 1U);
}

TEST(ShapeBounds, AreEmptyWithoutShapes) { EXPECT_TRUE(BoundsOf({}).isEmpty()); }

TEST(ShapeBounds, ContainATurnedCubeAndALine) {
  SceneShapes shapes;
  SolidShape& cube = shapes.cubes.emplace_back();
  cube.pose.leftCols<3>() = Eigen::AngleAxisd(M_PI / 4, Eigen::Vector3d::UnitZ()).toRotationMatrix() * 2;
  cube.pose.col(3) = Eigen::Vector3d(10, 0, 0);
  shapes.lines.push_back({{0, -5, 0}, {0, 1, 7}});
  const Eigen::AlignedBox3d box = BoundsOf(shapes);
  EXPECT_TRUE(box.min().isApprox(Eigen::Vector3d(0, -5, -1)));
  EXPECT_TRUE(box.max().isApprox(Eigen::Vector3d(10 + std::sqrt(2), std::sqrt(2), 7)));
}

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
