#include "simulated_building.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace slam2d {
namespace {

TEST(SimulatedBuilding, GivesTheSameScansForTheSameSeed) {
  SimulationOptions options;
  options.scans = 30;
  SimulatedBuilding one(options);
  SimulatedBuilding other(options);
  options.seed = 2;
  SimulatedBuilding differing(options);
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
