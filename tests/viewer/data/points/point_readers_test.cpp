#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <string>

#include "viewer/data/points/cloud_reader.hpp"
#include "viewer/data/points/scan_reader.hpp"
#include "viewer/e2e/message_parts.hpp"

namespace hgros::viewer {
namespace {

using foxglove::PackedElementField;
using ::testing::HasSubstr;

/// A cloud whose points have the fields in the order in which they were added.
class CloudOf {
 public:
  CloudOf& Field(const std::string& name, PackedElementField::NumericType type, std::uint32_t size_bytes) {
    test::AddPointField(cloud_, name, type, size_bytes);
    return *this;
  }
  template <class T>
  CloudOf& Value(T value) {
    cloud_.mutable_data()->append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  CloudOf& Floats() {
    for (const char* name : {"x", "y", "z"}) Field(name, PackedElementField::FLOAT32, 4);
    return *this;
  }
  [[nodiscard]] foxglove::PointCloud& cloud() { return cloud_; }
  [[nodiscard]] Bulk<foxglove::PointCloud> Message() const { return Bulk<foxglove::PointCloud>(cloud_); }
  [[nodiscard]] PointBatch Read() const {
    PointBatch batch;
    EXPECT_EQ(ReadCloud(Message(), "", batch), "");
    return batch;
  }

 private:
  foxglove::PointCloud cloud_;
};

TEST(CloudReader, ReadsPositionsAndIntensity) {
  CloudOf cloud;
  cloud.Floats().Field("intensity", PackedElementField::UINT16, 2);
  cloud.Value(1.0F).Value(2.0F).Value(3.0F).Value(std::uint16_t{500});
  cloud.cloud().set_frame_id("lidar");
  const PointBatch batch = cloud.Read();
  EXPECT_EQ(batch.frame, "lidar");
  ASSERT_EQ(batch.positions.size(), 1U);
  EXPECT_EQ(batch.positions[0], Eigen::Vector3f(1, 2, 3));
  EXPECT_THAT(batch.scalars, ::testing::ElementsAre(500.0F));
  EXPECT_EQ(batch.scalar_name, "intensity");
  EXPECT_THAT(batch.fields, ::testing::ElementsAre("intensity"));
}

TEST(CloudReader, OmitsPointsThatAreNotNumbers) {
  CloudOf cloud;
  cloud.Floats().Value(1.0F).Value(2.0F).Value(std::numeric_limits<float>::quiet_NaN());
  cloud.Value(4.0F).Value(5.0F).Value(6.0F);
  const PointBatch batch = cloud.Read();
  EXPECT_EQ(batch.positions.size(), 1U);
  EXPECT_EQ(batch.left_out, 1U);
}

TEST(CloudReader, KeepsDistancesBetweenLargeDoublesAlsoIfTheFirstPointIsAtTheOrigin) {
  for (const bool first_at_origin : {false, true}) {
    SCOPED_TRACE(first_at_origin);
    CloudOf cloud;
    for (const char* name : {"x", "y", "z"}) cloud.Field(name, PackedElementField::FLOAT64, 8);
    if (first_at_origin) cloud.Value(0.0).Value(0.0).Value(0.0);
    for (const double step : {0.0, 0.001, 0.002}) cloud.Value(466'000.125).Value(5'420'000.25 + step).Value(10.0);
    const PointBatch batch = cloud.Read();
    ASSERT_EQ(batch.positions.size(), 3U) << "the origin is far from all others";
    EXPECT_NEAR(batch.positions[2].y() - batch.positions[1].y(), 0.001, 1e-6);
    EXPECT_NEAR((batch.T_frame_points * batch.positions[0].cast<double>()).y(), 5'420'000.25, 1e-6);
  }
}

TEST(CloudReader, ReadsPackedAndSeparateColors) {
  CloudOf packed;
  packed.Floats().Field("rgb", PackedElementField::FLOAT32, 4);
  packed.Value(0.0F).Value(0.0F).Value(0.0F).Value(std::uint32_t{0x00112233});
  PointBatch batch = packed.Read();
  EXPECT_THAT(batch.colors, ::testing::ElementsAre(0xFF332211U));

  CloudOf separate;
  separate.Floats();
  for (const char* name : {"red", "green", "blue"}) separate.Field(name, PackedElementField::UINT8, 1);
  separate.Value(0.0F).Value(0.0F).Value(0.0F);
  separate.Value(std::uint8_t{0x11}).Value(std::uint8_t{0x22}).Value(std::uint8_t{0x33});
  ASSERT_EQ(ReadCloud(separate.Message(), "", batch), "");
  EXPECT_THAT(batch.colors, ::testing::ElementsAre(0xFF332211U));
}

TEST(CloudReader, PutsACloudWithoutZIntoThePlane) {
  CloudOf cloud;
  cloud.Field("x", PackedElementField::FLOAT32, 4).Field("y", PackedElementField::FLOAT32, 4);
  cloud.Value(1.0F).Value(2.0F);
  EXPECT_EQ(cloud.Read().positions.at(0), Eigen::Vector3f(1, 2, 0));
}

TEST(CloudReader, ReportsErrorsAndKeepsTheBatch) {
  PointBatch batch;
  batch.frame = "before";
  CloudOf cut;
  cut.Floats().Value(1.0F);
  EXPECT_NE(ReadCloud(cut.Message(), "", batch), "");

  CloudOf without_x;
  without_x.Field("y", PackedElementField::FLOAT32, 4).Value(1.0F);
  EXPECT_THAT(ReadCloud(without_x.Message(), "", batch), HasSubstr("\"x\""));

  CloudOf good;
  good.Floats().Value(1.0F).Value(2.0F).Value(3.0F);
  EXPECT_THAT(ReadCloud(good.Message(), "ring", batch), HasSubstr("\"ring\""));
  EXPECT_EQ(batch.frame, "before");
}

TEST(CloudReader, ReadsAnEmptyCloud) { EXPECT_TRUE(CloudOf().Read().positions.empty()); }

foxglove::LaserScan HalfTurn() {
  foxglove::LaserScan scan;
  scan.set_frame_id("laser");
  scan.mutable_timestamp()->set_seconds(7);
  scan.set_start_angle(-std::numbers::pi / 2);
  scan.set_end_angle(std::numbers::pi / 2);
  for (const double range : {1.0, 2.0, 3.0}) scan.add_ranges(range);
  return scan;
}

PointBatch Read(const foxglove::LaserScan& scan) {
  PointBatch batch;
  EXPECT_EQ(ReadScan(scan, batch), "");
  return batch;
}

TEST(ScanReader, PutsEachRayAtItsAngle) {
  const PointBatch batch = Read(HalfTurn());
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
  const PointBatch batch = Read(scan);
  EXPECT_EQ(batch.positions.size(), 1U);
  EXPECT_EQ(batch.left_out, 2U);
}

TEST(ScanReader, UsesIntensitiesAndOmitsARayThatIsFarFromAllOthers) {
  foxglove::LaserScan scan = HalfTurn();
  scan.set_ranges(1, 1e30);
  for (const double intensity : {10.0, 20.0, 30.0}) scan.add_intensities(intensity);
  const PointBatch batch = Read(scan);
  ASSERT_EQ(batch.positions.size(), 2U);
  EXPECT_TRUE(batch.positions[1].isApprox(Eigen::Vector3f(0, 3, 0), 1e-6F));
  EXPECT_THAT(batch.scalars, ::testing::ElementsAre(10.0F, 30.0F));
  EXPECT_EQ(batch.left_out, 1U);
}

TEST(ScanReader, RefusesADifferentNumberOfIntensitiesAndRanges) {
  foxglove::LaserScan scan = HalfTurn();
  scan.add_intensities(1);
  PointBatch batch;
  EXPECT_THAT(ReadScan(scan, batch), ::testing::HasSubstr("3 ranges but 1 intensities"));
}

TEST(ScanReader, ReadsAnEmptyScan) { EXPECT_TRUE(Read(foxglove::LaserScan()).positions.empty()); }

}  // namespace
}  // namespace hgros::viewer
