#include "pose2.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>

#include "simulated_building.hpp"

namespace slam2d {
namespace {

Eigen::Isometry2d Oracle(const Pose2& T) {
  Eigen::Isometry2d oracle = Eigen::Isometry2d::Identity();
  oracle.translate(Eigen::Vector2d(T.x, T.y));
  oracle.rotate(T.theta);
  return oracle;
}

Pose2 RandomPose(SeededNoise& noise) {
  return {20.0 * noise.Uniform() - 10.0, 20.0 * noise.Uniform() - 10.0, 20.0 * noise.Uniform() - 10.0};
}

TEST(Pose2, ComposesInvertsAndMapsPointsLikeEigen) {
  SeededNoise noise(7);
  for (int i = 0; i < 500; ++i) {
    const Pose2 a = RandomPose(noise);
    const Pose2 b = RandomPose(noise);
    const Point2 p{noise.Normal(), noise.Normal()};
    EXPECT_TRUE(Oracle(a * b).isApprox(Oracle(a) * Oracle(b), 1e-12));
    EXPECT_TRUE(Oracle(Inverse(a)).isApprox(Oracle(a).inverse(), 1e-12));
    const Point2 mapped = a * p;
    const Eigen::Vector2d expected = Oracle(a) * Eigen::Vector2d(p.x, p.y);
    EXPECT_NEAR(mapped.x, expected.x(), 1e-12);
    EXPECT_NEAR(mapped.y, expected.y(), 1e-12);
  }
}

TEST(Pose2, WrapsEveryAngleIntoOneTurn) {
  EXPECT_NEAR(WrapAngle(3.0 * std::numbers::pi + 0.25), 0.25 - std::numbers::pi, 1e-12);
  EXPECT_NEAR(WrapAngle(-7.0), 2.0 * std::numbers::pi - 7.0, 1e-12);
  EXPECT_EQ(WrapAngle(1.5), 1.5);
  EXPECT_NEAR((Pose2{0, 0, 3.0} * Pose2{0, 0, 3.0}).theta, 6.0 - 2.0 * std::numbers::pi, 1e-12);
}

}  // namespace
}  // namespace slam2d
