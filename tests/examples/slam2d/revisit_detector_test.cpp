#include "revisit_detector.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "scan_matcher.hpp"
#include "simulated_building.hpp"

namespace slam2d {
namespace {

// A detector whose old map contains the first scans, and the last of these scans.
class OldRoom : public testing::Test {
 protected:
  OldRoom() : detector_({}, map_.options().cell_size_m, 0.08) {
    SimulatedBuilding building({.scans = 25});
    LaserScan2 scan;
    while (building.Next(scan)) detector_.Apply(map_.Integrate(scan, building.true_pose()), 0.0);
    true_pose_ = building.true_pose();
    points_ = MatchedPoints(scan, {});
  }

  void LeaveFor(double traveled_m) { detector_.Apply(map_.Skip(99), traveled_m); }

  OccupancyMap map_;
  RevisitDetector detector_;
  Pose2 true_pose_;
  std::vector<Point2> points_;
};

TEST_F(OldRoom, RevisitDetectorFindsNothingBeforeTheLagHasPassedAndInNewSurroundings) {
  LeaveFor(10.0);
  EXPECT_TRUE(detector_.old_field().empty());
  EXPECT_FALSE(detector_.Check(points_, true_pose_ * Pose2{0.5, 0.4, 0.0}, 10.0).doubtful);
  LeaveFor(40.0);
  const auto verdict = detector_.Check(points_, {200.0, 100.0, 0.0}, 40.0);
  EXPECT_FALSE(verdict.doubtful);
  EXPECT_FALSE(verdict.T_map_laser);
}

TEST_F(OldRoom, RevisitDetectorAgreesWithAPoseThatHasNotDrifted) {
  LeaveFor(40.0);
  for (double m = 40.0; m < 43.0; m += 0.3) {
    const auto verdict = detector_.Check(points_, true_pose_, m);
    EXPECT_FALSE(verdict.doubtful);
    EXPECT_FALSE(verdict.T_map_laser);
  }
}

TEST_F(OldRoom, RevisitDetectorCorrectsADriftAfterFindingItSeveralTimes) {
  LeaveFor(40.0);
  const Pose2 drifted = true_pose_ * Pose2{0.5, 0.4, 0.05};
  const int confirmations = RevisitOptions{}.confirmations;
  for (int i = 1; i <= confirmations; ++i) {
    const auto verdict = detector_.Check(points_, drifted, 40.0 + 0.3 * i);
    EXPECT_EQ(verdict.doubtful, i < confirmations);
    ASSERT_EQ(verdict.T_map_laser.has_value(), i == confirmations);
    if (!verdict.T_map_laser) continue;
    const Pose2 error = Inverse(true_pose_) * *verdict.T_map_laser;
    EXPECT_LT(Distance(error), 0.08);
    EXPECT_LT(std::abs(error.theta), 0.01);
  }
}

TEST_F(OldRoom, RevisitDetectorTakesNewOptionsInTheMiddleOfASearch) {
  LeaveFor(40.0);
  const Pose2 drifted = true_pose_ * Pose2{0.5, 0.4, 0.05};
  EXPECT_TRUE(detector_.Check(points_, drifted, 40.3).doubtful);
  detector_.SetOptions({.confirmations = 2});
  EXPECT_TRUE(detector_.Check(points_, drifted, 40.6).T_map_laser);
}

TEST_F(OldRoom, RevisitDetectorKeepsItsOldMapWhenTheLagGrows) {
  LeaveFor(40.0);
  detector_.SetOptions({.lag_m = 1000.0});
  LeaveFor(41.0);
  EXPECT_FALSE(detector_.old_field().empty());
}

}  // namespace
}  // namespace slam2d
