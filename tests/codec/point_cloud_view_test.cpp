#include "hgros/codec/point_cloud_view.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <random>
#include <ranges>

#include "foxglove/PointCloud.pb.h"
#include "hgros/codec/message.hpp"
#include "support/seed.hpp"

namespace hgros {
namespace {

using foxglove::PackedElementField;
using foxglove::PointCloud;
using ::testing::HasSubstr;

static_assert(std::ranges::random_access_range<StridedView<float>>);

struct Point {
  float x;
  float y;
  double time;
  std::uint16_t ring;
  std::uint8_t pad[6];
};
static_assert(sizeof(Point) == 24);

void AddField(PointCloud& cloud, const std::string& name, std::uint32_t offset, PackedElementField::NumericType type) {
  auto* const field = cloud.add_fields();
  field->set_name(name);
  field->set_offset(offset);
  field->set_type(type);
}

void Describe(PointCloud& cloud) {
  cloud.set_point_stride(sizeof(Point));
  AddField(cloud, "x", offsetof(Point, x), PackedElementField::FLOAT32);
  AddField(cloud, "y", offsetof(Point, y), PackedElementField::FLOAT32);
  AddField(cloud, "time", offsetof(Point, time), PackedElementField::FLOAT64);
  AddField(cloud, "ring", offsetof(Point, ring), PackedElementField::UINT16);
}

std::string Points(std::size_t count) {
  std::string bytes;
  for (std::size_t i = 0; i < count; ++i) {
    const Point point{
        static_cast<float>(i), -static_cast<float>(i), 0.5 * static_cast<double>(i), static_cast<std::uint16_t>(i), {}};
    bytes.append(reinterpret_cast<const char*>(&point), sizeof point);
  }
  return bytes;
}

PointCloud Cloud(std::size_t count) {
  PointCloud cloud;
  Describe(cloud);
  cloud.set_data(Points(count));
  return cloud;
}

template <class T>
std::string FaultOf(const PointCloud& cloud, const std::string& field) {
  const auto points = ViewPoints(cloud);
  if (!points) return points.fault();
  const auto values = points->Field<T>(field);
  return values ? "" : values.fault();
}

TEST(PointCloudView, ShowsTheValuesOfEachField) {
  const PointCloud cloud = Cloud(100);
  const auto points = ViewPoints(cloud);
  ASSERT_TRUE(points) << points.fault();
  EXPECT_EQ(points->size(), 100U);
  const auto x = points->Field<float>("x");
  const auto time = points->Field<double>("time");
  const auto ring = points->Field<std::uint16_t>("ring");
  ASSERT_TRUE(x && time && ring);
  ASSERT_EQ(x->size(), 100U);
  for (std::size_t i = 0; i < 100; ++i) {
    EXPECT_EQ((*x)[i], static_cast<float>(i));
    EXPECT_EQ((*time)[i], 0.5 * static_cast<double>(i));
    EXPECT_EQ((*ring)[i], i);
  }
  EXPECT_EQ(std::ranges::max(*x), 99.0F);
  float sum = 0;
  for (const float value : *points->Field<float>("x")) sum += value;
  EXPECT_EQ(sum, 4950.0F);
  EXPECT_EQ(std::ranges::lower_bound(*x, 40.5F) - x->begin(), 41);
}

TEST(PointCloudView, ViewsABulkInPlace) {
  Bulk<PointCloud> cloud(10 * sizeof(Point));
  Describe(cloud.head());
  const std::string bytes = Points(10);
  std::memcpy(cloud.writable().data(), bytes.data(), bytes.size());
  const auto points = ViewPoints(cloud);
  ASSERT_TRUE(points) << points.fault();
  EXPECT_EQ(points->data().data(), cloud.bytes().data());
  EXPECT_EQ((*points->Field<float>("y"))[9], -9.0F);
}

TEST(PointCloudView, ReadsAtAnyAlignment) {
  PointCloud cloud;
  cloud.set_point_stride(7);
  AddField(cloud, "v", 1, PackedElementField::INT32);
  cloud.set_data(std::string("\1\x2a\0\0\0\1\1\1\xff\xff\xff\xff\1\1", 14));
  const auto points = ViewPoints(cloud);
  ASSERT_TRUE(points);
  const auto values = points->Field<std::int32_t>("v");
  ASSERT_TRUE(values) << values.fault();
  EXPECT_EQ((*values)[0], 42);
  EXPECT_EQ((*values)[1], -1);
}

TEST(PointCloudView, ReportsTheInvalidFieldAndWhy) {
  EXPECT_THAT(FaultOf<float>(Cloud(2), "z"), HasSubstr("no field \"z\"; there are: x, y, time, ring."));
  EXPECT_THAT(FaultOf<double>(Cloud(2), "x"), HasSubstr("\"x\" holds FLOAT32, not FLOAT64"));
  EXPECT_THAT(FaultOf<std::int16_t>(Cloud(2), "ring"), HasSubstr("\"ring\" holds UINT16, not INT16"));
  PointCloud cloud = Cloud(2);
  cloud.mutable_fields(0)->set_offset(21);
  EXPECT_THAT(FaultOf<float>(cloud, "x"),
              HasSubstr("\"x\" begins at byte 21 and has 4 bytes, but an element has only 24"));
  cloud.mutable_fields(0)->set_offset(20);
  EXPECT_EQ(FaultOf<float>(cloud, "x"), "");
  cloud.mutable_fields(0)->set_offset(std::numeric_limits<std::uint32_t>::max());
  EXPECT_THAT(FaultOf<float>(cloud, "x"), HasSubstr("begins at byte 4294967295"));
  cloud.mutable_fields(0)->set_type(static_cast<PackedElementField::NumericType>(77));
  EXPECT_THAT(FaultOf<float>(cloud, "x"), HasSubstr("values of type 77, which does not exist"));
}

TEST(PointCloudView, RefusesPartialPoints) {
  PointCloud cloud = Cloud(2);
  cloud.set_point_stride(0);
  EXPECT_THAT(FaultOf<float>(cloud, "x"), HasSubstr("stride of 0"));
  cloud.set_point_stride(25);
  EXPECT_THAT(FaultOf<float>(cloud, "x"), HasSubstr("48 bytes are not a whole number of elements of 25 bytes"));
  cloud.set_point_stride(std::numeric_limits<std::uint32_t>::max());
  EXPECT_THAT(FaultOf<float>(cloud, "x"), HasSubstr("not a whole number"));
}

TEST(PointCloudView, IsEmptyForZeroPointsAndNoneForAFault) {
  const PointCloud cloud = Cloud(0);
  const auto points = ViewPoints(cloud);
  ASSERT_TRUE(points);
  EXPECT_EQ(points->size(), 0U);
  EXPECT_TRUE(points->Field<float>("x")->empty());
  const PointCloud nothing;
  ASSERT_FALSE(ViewPoints(nothing));
  EXPECT_THROW((void)ViewPoints(nothing)->size(), std::bad_optional_access);
}

// For any message, every value of a view must be inside its bytes. The sanitizers check that.
TEST(PointCloudView, NeverReadsOutsideItsBytes) {
  std::mt19937 random(test::Seed());
  const auto any = [&random](std::uint32_t most) {
    const std::uint32_t small = std::uniform_int_distribution<std::uint32_t>(0, most)(random);
    return random() % 8 == 0 ? static_cast<std::uint32_t>(random()) : small;
  };
  for (int round = 0; round < 20'000; ++round) {
    PointCloud cloud;
    cloud.set_point_stride(any(20));
    AddField(cloud, "v", any(20), PackedElementField::FLOAT64);
    cloud.set_data(std::string(std::uniform_int_distribution<std::size_t>(0, 100)(random), 'x'));
    const auto points = ViewPoints(cloud);
    if (!points) continue;
    const auto values = points->Field<double>("v");
    if (!values) continue;
    ASSERT_EQ(values->size() * cloud.point_stride(), cloud.data().size());
    double sum = 0;
    for (const double value : *values) sum += value;
    EXPECT_GE(sum, 0);
  }
}

}  // namespace
}  // namespace hgros
