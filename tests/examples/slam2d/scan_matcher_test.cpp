#include "scan_matcher.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "pipeline.hpp"
#include "simulated_building.hpp"

namespace slam2d {
namespace {

TEST(ScanMatcher, StartsAtTheFirstOdometryPoseAndRefusesAScanBeforeTheMapOfThePreviousOne) {
  SimulatedBuilding building;
  LaserScan2 scan;
  ScanMatcher matcher({}, {});
  Mapper mapper{MapOptions{}};
  ASSERT_TRUE(building.Next(scan));
  const ScanMatch first = matcher.Match(scan);
  EXPECT_EQ(first.T_map_laser, scan.odometry);
  EXPECT_EQ(first.score, 0.0);
  matcher.Apply(mapper.Add(scan, first));
  ASSERT_TRUE(building.Next(scan));
  (void)matcher.Match(scan);
  ASSERT_TRUE(building.Next(scan));
  EXPECT_THROW((void)matcher.Match(scan), std::logic_error);
}

TEST(ScanMatcher, UsesOnlyOdometryIfTheScanIsEmpty) {
  SimulatedBuilding building;
  LaserScan2 scan;
  ASSERT_TRUE(building.Next(scan));
  Pipeline pipeline;
  pipeline.Add(scan);
  scan.sequence = 1;
  scan.odometry = scan.odometry * Pose2{0.3, 0.0, 0.1};
  scan.ranges_m.assign(scan.ranges_m.size(), static_cast<float>(scan.max_range_m));
  const ScanMatch& match = pipeline.Add(scan);
  EXPECT_EQ(match.T_map_laser, scan.odometry);
  EXPECT_EQ(match.score, 0.0);
}

TEST(ScanMatcher, ThinsNearPointsAndDropsFarOnes) {
  LaserScan2 scan;
  scan.angle_step_rad = 0.01;
  scan.max_range_m = 50.0;
  scan.ranges_m.assign(100, 1.0F);
  scan.ranges_m.push_back(49.0F);
  MatcherOptions options;
  EXPECT_NEAR(static_cast<double>(MatchedPoints(scan, options).size()), 1.0 / options.point_spacing_m, 2.0);
}

// The first scans of a building, and the parts of a pipeline that have processed all of them except the last.
class OnTheWay : public testing::Test {
 protected:
  OnTheWay() {
    SimulatedBuilding building({.scans = 12});
    while (building.Next(scan_) && scan_.sequence < 11) matcher_.Apply(mapper_.Add(scan_, matcher_.Match(scan_)));
  }

  ScanMatcher matcher_{{}, {}};
  Mapper mapper_{MapOptions{}};
  LaserScan2 scan_;
};

TEST_F(OnTheWay, ScanMatcherMatchesWithNewOptionsFromTheNextScanOn) {
  ScanMatcher same = matcher_;
  EXPECT_GT(same.Match(scan_).score, 0.5);
  matcher_.SetOptions({.min_points = 100000, .revisit = {}});
  EXPECT_EQ(matcher_.Match(scan_).score, 0.0);
}

TEST_F(OnTheWay, ScanMatcherKeepsItsFieldWhenItsOptionsChange) {
  ScanMatcher same = matcher_;
  matcher_.SetOptions({.field_sigma_m = 0.4, .revisit = {}});
  EXPECT_EQ(matcher_.Match(scan_), same.Match(scan_));
}

TEST_F(OnTheWay, ScanMatcherGoesOnAtItsPoseWithAnotherMap) {
  ScanMatcher same = matcher_;
  matcher_.SetMap(OccupancyMap());
  MapDelta none;
  none.version = same.replica().version();
  matcher_.Apply(none);
  const ScanMatch match = matcher_.Match(scan_);
  EXPECT_EQ(match.score, 0.0);  // There is nothing to match with.
  EXPECT_LT(Distance(Inverse(same.Match(scan_).T_map_laser) * match.T_map_laser), 0.5);
}

TEST(ScanMatcher, FollowsAMapWithCellsOfAnotherSize) {
  const MapOptions coarse{.cell_size_m = 0.1};
  SimulatedBuilding building({.scans = 12});
  Pipeline pipeline({}, coarse);
  ScanMatcher told({}, {});
  Mapper mapper(coarse);
  LaserScan2 scan;
  while (building.Next(scan)) {
    const ScanMatch match = told.Match(scan);
    EXPECT_EQ(match, pipeline.Add(scan));
    const MapDelta delta = mapper.Add(scan, match);
    if (scan.sequence == 0) told.SetMap(OccupancyMap(coarse));
    told.Apply(delta);
  }
}

}  // namespace
}  // namespace slam2d
