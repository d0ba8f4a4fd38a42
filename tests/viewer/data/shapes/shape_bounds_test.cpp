#include "viewer/data/shapes/shape_bounds.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace hgros::viewer {
namespace {

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

}  // namespace
}  // namespace hgros::viewer
