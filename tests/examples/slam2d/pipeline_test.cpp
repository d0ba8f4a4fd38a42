#include "pipeline.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "simulated_building.hpp"

namespace slam2d {
namespace {

TEST(Pipeline, TracksTheSimulatedRobotAlthoughOdometryDrifts) {
  SimulationOptions options;
  options.beams = 120;  // Fewer than usual, for speed.
  SimulatedBuilding building(options);
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

TEST(Pipeline, GivesTheSameHashesInEveryRun) {
  SimulationOptions options;
  options.scans = 60;
  std::uint64_t map_hash[2] = {};
  std::uint64_t trajectory_hash[2] = {};
  for (int run = 0; run < 2; ++run) {
    SimulatedBuilding building(options);
    Pipeline pipeline;
    LaserScan2 scan;
    while (building.Next(scan)) pipeline.Add(scan);
    map_hash[run] = HashMap(pipeline.map());
    trajectory_hash[run] = HashTrajectory(pipeline.trajectory());
  }
  EXPECT_EQ(map_hash[0], map_hash[1]);
  EXPECT_EQ(trajectory_hash[0], trajectory_hash[1]);
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

}  // namespace
}  // namespace slam2d
