#include "viewer/data/points/scan_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <numbers>

namespace hgros::viewer {
namespace {

foxglove::LaserScan HalfTurn() {
  foxglove::LaserScan scan;
  scan.set_frame_id("laser");
  scan.mutable_timestamp()->set_seconds(7);
  scan.set_start_angle(-std::numbers::pi / 2);
  scan.set_end_angle(std::numbers::pi / 2);
  for (const double range : {1.0, 2.0, 3.0}) scan.add_ranges(range);
  return scan;
}

TEST(ScanReader, PutsEachRayAtItsAngle) {
  PointBatch batch;
  ASSERT_EQ(ReadScan(HalfTurn(), batch), "");
  EXPECT_EQ(batch.frame, "laser");
  EXPECT_EQ(batch.stamp, (Time{7'000'000'000}));
  ASSERT_EQ(batch.positions.size(), 3U);
  EXPECT_TRUE(batch.positions[0].isApprox(Eigen::Vector3f(0, -1, 0), 1e-6F));
  EXPECT_TRUE(batch.positions[1].isApprox(Eigen::Vector3f(2, 0, 0), 1e-6F));
  EXPECT_TRUE(batch.positions[2].isApprox(Eigen::Vector3f(0, 3, 0), 1e-6F));
  EXPECT_EQ(batch.scalar_name, "range");
}

TEST(ScanReader, OmitsRaysWithoutAReturn) {
  foxglove::LaserScan scan = HalfTurn();
  scan.set_ranges(0, std::numeric_limits<double>::infinity());
  scan.set_ranges(1, std::numeric_limits<double>::quiet_NaN());
  PointBatch batch;
  ASSERT_EQ(ReadScan(scan, batch), "");
  EXPECT_EQ(batch.positions.size(), 1U);
  EXPECT_EQ(batch.left_out, 2U);
}

TEST(ScanReader, OmitsARayThatIsFarFromAllOthers) {
  foxglove::LaserScan scan = HalfTurn();
  scan.set_ranges(1, 1e30);
  for (const double intensity : {10.0, 20.0, 30.0}) scan.add_intensities(intensity);
  PointBatch batch;
  ASSERT_EQ(ReadScan(scan, batch), "");
  ASSERT_EQ(batch.positions.size(), 2U);
  EXPECT_TRUE(batch.positions[1].isApprox(Eigen::Vector3f(0, 3, 0), 1e-6F));
  EXPECT_THAT(batch.scalars, ::testing::ElementsAre(10.0F, 30.0F));
  EXPECT_EQ(batch.left_out, 1U);
}

TEST(ScanReader, UsesIntensitiesIfThereAreAny) {
  foxglove::LaserScan scan = HalfTurn();
  for (const double intensity : {10.0, 20.0, 30.0}) scan.add_intensities(intensity);
  PointBatch batch;
  ASSERT_EQ(ReadScan(scan, batch), "");
  EXPECT_THAT(batch.scalars, ::testing::ElementsAre(10.0F, 20.0F, 30.0F));
}

TEST(ScanReader, RefusesADifferentNumberOfIntensitiesAndRanges) {
  foxglove::LaserScan scan = HalfTurn();
  scan.add_intensities(1);
  PointBatch batch;
  EXPECT_THAT(ReadScan(scan, batch), ::testing::HasSubstr("3 ranges but 1 intensities"));
}

TEST(ScanReader, ReadsAnEmptyScan) {
  PointBatch batch;
  ASSERT_EQ(ReadScan(foxglove::LaserScan(), batch), "");
  EXPECT_TRUE(batch.positions.empty());
}

}  // namespace
}  // namespace hgros::viewer
