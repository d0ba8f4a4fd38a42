#include "occupancy_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "mapper.hpp"
#include "pipeline.hpp"
#include "simulated_building.hpp"

namespace slam2d {
namespace {

LaserScan2 RandomScan(std::uint64_t sequence, SeededNoise& noise) {
  LaserScan2 scan;
  scan.sequence = sequence;
  scan.start_angle_rad = -std::numbers::pi / 2;
  scan.angle_step_rad = std::numbers::pi / 60;
  scan.max_range_m = 35.0;
  for (int i = 0; i < 60; ++i) scan.ranges_m.push_back(static_cast<float>(36.0 * noise.Uniform()));
  return scan;
}

LaserScan2 OneBeam(double range_m) {
  LaserScan2 scan;
  scan.max_range_m = 50.0;
  scan.ranges_m = {static_cast<float>(range_m)};
  return scan;
}

TEST(OccupancyMap, ClearsTheCellsThatABeamCrossesAndMarksItsLastCell) {
  MapOptions options;
  OccupancyMap map(options);
  map.Integrate(OneBeam(1.02), {0.025, 0.025, 0.0});
  for (int x = 0; x < 20; ++x) EXPECT_EQ(map.At(x, 0), -options.miss_loss) << x;
  EXPECT_EQ(map.At(20, 0), options.hit_gain);
  EXPECT_EQ(map.At(21, 0), 0);
  EXPECT_EQ(map.At(-1, 0), 0);
  EXPECT_EQ(map.At(10, 1), 0);
}

TEST(OccupancyMap, ClearsOnlyUpToTheUsableRange) {
  const MapOptions options{.max_hit_range_m = 2.0};
  OccupancyMap map(options);
  map.Integrate(OneBeam(5.0), {0.025, 0.025, 0.0});
  EXPECT_LT(map.At(38, 0), 0);
  EXPECT_EQ(map.At(100, 0), 0);
  OccupancyMap no_return(options);
  EXPECT_TRUE(no_return.Integrate(OneBeam(50.0), {}).cells.empty());
}

TEST(OccupancyMap, DrawsAWallBetweenSparseCollinearReturnsButNotThroughKnownFreeSpace) {
  // A wall along y = 1 m, seen at a flat angle by beams that meet it 0.5 m apart.
  LaserScan2 scan;
  scan.max_range_m = 50.0;
  scan.start_angle_rad = std::atan2(1.025, 6.0);
  scan.angle_step_rad = scan.start_angle_rad / 40.0;
  for (int i = 0; i < 5; ++i) {
    const double angle = scan.start_angle_rad + i * scan.angle_step_rad;
    scan.ranges_m.push_back(static_cast<float>(1.025 / std::sin(angle)));
  }
  const auto occupied = [](const OccupancyMap& map) {
    int count = 0;
    for (int x = 60; x < 130; ++x) count += map.At(x, 20) > 0 ? 1 : 0;
    return count;
  };
  OccupancyMap bridged;
  bridged.Integrate(scan, {});
  OccupancyMap plain({.max_bridge_m = 0.0});
  plain.Integrate(scan, {});
  EXPECT_EQ(occupied(plain), 5);
  EXPECT_GT(occupied(bridged), 8);
  OccupancyMap free_before;
  for (int i = 0; i < 3; ++i) free_before.Integrate(OneBeam(9.0), {0.0, 1.025, 0.0});
  free_before.Integrate(scan, {});
  EXPECT_LE(occupied(free_before), 5);
}

TEST(OccupancyMap, KeepsValuesWithinTheirClamps) {
  MapOptions options;
  OccupancyMap map(options);
  for (int i = 0; i < 50; ++i) map.Integrate(OneBeam(1.02), {0.025, 0.025, 0.0});
  EXPECT_EQ(map.At(20, 0), options.max_value);
  EXPECT_EQ(map.At(5, 0), options.min_value);
  EXPECT_TRUE(map.Integrate(OneBeam(1.02), {0.025, 0.025, 0.0}).cells.empty()) << "no further changes";
}

TEST(OccupancyMap, ReplicaThatAppliesEveryDeltaIsEqualBitForBitAndDeltasAreDifferences) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    SeededNoise noise(seed);
    OccupancyMap original;
    OccupancyMap replica;
    for (std::uint64_t k = 0; k < 40; ++k) {
      const LaserScan2 scan = RandomScan(k, noise);
      const Pose2 pose{30.0 * noise.Uniform() - 15.0, 30.0 * noise.Uniform() - 15.0, 7.0 * noise.Uniform()};
      const OccupancyMap before = original;
      const MapDelta delta = k % 5 == 4 ? original.Skip(k) : original.Integrate(scan, pose);
      ASSERT_EQ(Difference(before, original), delta) << "seed " << seed << ", scan " << k;
      OccupancyMap back = original;
      back.Apply(Difference(original, before));
      ASSERT_EQ(Difference(before, back).cells.size(), 0U) << "seed " << seed << ", scan " << k;
      replica.Apply(delta);
      ASSERT_EQ(replica.version(), k);
      ASSERT_TRUE(replica.tiles() == original.tiles()) << "seed " << seed << ", scan " << k;
    }
    EXPECT_EQ(HashMap(replica), HashMap(original));
  }
}

TEST(OccupancyMap, ReturnsAnEmptyDeltaWithTheNewVersionForASkippedScan) {
  OccupancyMap map;
  map.Integrate(OneBeam(2.0), {});
  const auto tiles = map.tiles();
  const MapDelta delta = map.Skip(17);
  EXPECT_EQ(delta.version, 17U);
  EXPECT_EQ(map.version(), 17U);
  EXPECT_TRUE(delta.tiles.empty() && delta.cells.empty() && delta.values.empty());
  EXPECT_TRUE(map.tiles() == tiles);
}

TEST(OccupancyMap, RejectsInconsistentDeltasAndStaysUnchanged) {
  OccupancyMap map;
  const MapDelta good = OccupancyMap().Integrate(OneBeam(2.0), {});
  MapDelta cell_outside = good;
  cell_outside.cells[0] = 4096;
  MapDelta value_missing = good;
  value_missing.values.pop_back();
  MapDelta count_too_large = good;
  count_too_large.tiles[0].count = 0xffffffffU;
  MapDelta gap = good;
  gap.tiles[0].first = 1;
  for (const MapDelta& bad : {cell_outside, value_missing, count_too_large, gap}) {
    EXPECT_THROW(map.Apply(bad), std::invalid_argument);
    EXPECT_TRUE(map.tiles().empty());
  }
}

TEST(Mapper, DrawsAScanOnlyAfterEnoughMotionAndOnlyWhereThePoseIsTrusted) {
  Mapper mapper{MapOptions{}};
  LaserScan2 scan = OneBeam(2.0);
  ScanMatch match;
  EXPECT_FALSE(mapper.Add(scan, match).cells.empty());
  scan.sequence = 1;
  match.T_map_laser.x = 0.05;
  const MapDelta still = mapper.Add(scan, match);
  EXPECT_TRUE(still.cells.empty());
  EXPECT_EQ(still.version, 1U);
  match.T_map_laser.x = 0.5;
  match.drawable = false;
  EXPECT_TRUE(mapper.Add(scan, match).cells.empty());
  match.drawable = true;
  EXPECT_FALSE(mapper.Add(scan, match).cells.empty());
  match.T_map_laser.x = 0.6;
  EXPECT_TRUE(mapper.Add(scan, match).cells.empty());
  mapper.SetOptions({.min_translation_m = 0.08});
  EXPECT_FALSE(mapper.Add(scan, match).cells.empty());
}

TEST(OccupancyMap, NewOptionsKeepCellSizeAndValueRange) {
  OccupancyMap map;
  map.SetOptions({.cell_size_m = 0.5, .hit_gain = 7, .max_value = 127, .min_value = -127});
  map.Integrate(OneBeam(1.02), {0.025, 0.025, 0.0});
  EXPECT_EQ(map.At(20, 0), 7);
  EXPECT_EQ(map.options().hit_gain, 7);
  EXPECT_EQ(map.options().cell_size_m, MapOptions{}.cell_size_m);
  EXPECT_EQ(map.options().max_value, MapOptions{}.max_value);
  EXPECT_EQ(map.options().min_value, MapOptions{}.min_value);
}

}  // namespace
}  // namespace slam2d
