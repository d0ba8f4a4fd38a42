#include "pipeline.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "pose2.hpp"
#include "simulated_building.hpp"

namespace slam2d {
namespace {

TEST(Pipeline, TracksTheSimulatedRobotAlthoughOdometryDrifts) {
  SimulatedBuilding building({.beams = 120});  // Fewer than usual, for speed.
  Pipeline pipeline;
  LaserScan2 scan;
  double error = 0.0;
  double worst = 0.0;
  double odometry_error = 0.0;
  while (building.Next(scan)) {
    const Pose2 T_laser_true = Inverse(building.true_pose());
    error = Distance(T_laser_true * pipeline.Add(scan).T_map_laser);
    worst = std::max(worst, error);
    odometry_error = Distance(T_laser_true * scan.odometry);
  }
  EXPECT_LT(error, 0.15);
  EXPECT_LT(worst, 0.25);
  EXPECT_GT(odometry_error, 1.0);
}

TEST(Pipeline, HashesDifferForDifferentMapsAndTrajectories) {
  OccupancyMap map;
  const std::uint64_t empty = HashMap(map);
  map.Skip(1);
  EXPECT_NE(HashMap(map), empty);
  ScanMatch match;
  const std::uint64_t one = HashTrajectory({&match, 1});
  match.T_map_laser.theta = std::nextafter(0.0, 1.0);
  EXPECT_NE(HashTrajectory({&match, 1}), one);
}

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

TEST(SimulatedBuilding, GivesTheSameScansForTheSameSeed) {
  SimulatedBuilding one({.scans = 30});
  SimulatedBuilding other({.scans = 30});
  SimulatedBuilding differing({.seed = 2, .scans = 30});
  LaserScan2 a;
  LaserScan2 b;
  LaserScan2 c;
  while (one.Next(a)) {
    ASSERT_TRUE(other.Next(b));
    ASSERT_TRUE(differing.Next(c));
    ASSERT_EQ(a.ranges_m, b.ranges_m);
    ASSERT_EQ(a.odometry, b.odometry);
    ASSERT_NE(a.ranges_m, c.ranges_m);
  }
  EXPECT_FALSE(other.Next(b));
}

TEST(SimulatedBuilding, RobotRepeatsItsRouteAndNeverCrossesAWall) {
  SimulatedBuilding building;
  LaserScan2 scan;
  Point2 start;
  double nearest = 100.0;
  bool away = false;
  int returns = 0;
  while (building.Next(scan)) {
    const Pose2& pose = building.true_pose();
    if (scan.sequence == 0) start = {pose.x, pose.y};
    const double from_start = std::hypot(pose.x - start.x, pose.y - start.y);
    if (away && from_start < 1.0) ++returns;
    away = from_start > 5.0 || (away && from_start >= 1.0);
    for (int i = 0; i < 12; ++i) {
      nearest = std::min(nearest, building.Range({pose.x, pose.y}, 0.5236 * i, 30.0));
    }
  }
  EXPECT_GE(returns, 1);
  EXPECT_GT(nearest, 0.15);
}

TEST(SimulatedBuilding, MeasuresTheDistanceToTheWalls) {
  const SimulatedBuilding building;
  EXPECT_NEAR(building.Range({5.0, 4.0}, -1.5707963267948966, 30.0), 1.0, 1e-9);
  EXPECT_NEAR(building.Range({5.0, 4.0}, 1.5707963267948966, 30.0), 0.9, 1e-9);
  EXPECT_EQ(building.Range({5.0, 4.0}, 0.0, 2.0), 2.0);
}

}  // namespace
}  // namespace slam2d
