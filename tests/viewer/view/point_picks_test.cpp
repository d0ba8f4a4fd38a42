#include "viewer/view/point_picks.hpp"

#include <gtest/gtest.h>

namespace hgros::viewer {
namespace {

PickedPoint At(double x, double y, double z) {
  PickedPoint point;
  point.at = {x, y, z};
  return point;
}

TEST(PointPicks, MeasuresFromTheFirstToTheSecond) {
  PointPicks picks;
  picks.Add(At(1, 1, 1));
  EXPECT_FALSE(picks.measurement()) << "one point alone has no distance";
  picks.Add(At(4, 5, 13));
  const auto measured = picks.measurement();
  ASSERT_TRUE(measured);
  EXPECT_EQ(measured->step, Eigen::Vector3d(3, 4, 12));
  EXPECT_DOUBLE_EQ(measured->distance, 13);
  EXPECT_DOUBLE_EQ(measured->in_plane, 5);
}

TEST(PointPicks, StartsAgainWithTheThirdPoint) {
  PointPicks picks;
  for (int i = 0; i < 3; ++i) picks.Add(At(i, 0, 0));
  ASSERT_EQ(picks.points().size(), 1U);
  EXPECT_EQ(picks.points()[0].at.x(), 2);
  picks.Clear();
  EXPECT_TRUE(picks.points().empty());
}

TEST(PointPicks, MeasuresExactlyFarFromTheOrigin) {
  PointPicks picks;
  picks.Add(At(500'000.125, 5'400'000.5, 300));
  picks.Add(At(500'000.250, 5'400'000.5, 300));
  EXPECT_DOUBLE_EQ(picks.measurement()->distance, 0.125);
}

TEST(PointPicks, WritesMetersWithSuitableDecimals) {
  EXPECT_EQ(MetersText(Eigen::Vector3d(1.23456, -2, 0)), "1.235, -2.000, 0.000 m");
  EXPECT_EQ(MetersText(Eigen::Vector3d(500000.127, 5400000.5, 300)), "500000.1, 5400000.5, 300.0 m");
  EXPECT_EQ(MetersText(12.5), "12.500 m");
}

}  // namespace
}  // namespace hgros::viewer
