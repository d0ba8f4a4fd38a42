#include "viewer/data/shapes/far_shapes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

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

}  // namespace
}  // namespace hgros::viewer
