#include "viewer/data/packed_points.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace hgros::viewer {
namespace {

TEST(PackedPoints, KeepPositionsAndValuesWithinAStep) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> metres(-100, 100);
  std::vector<Eigen::Vector3d> positions(500);
  std::vector<float> values(500);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    positions[i] = Eigen::Vector3d(metres(random) + 1e6, metres(random), metres(random));
    values[i] = static_cast<float>(metres(random));
  }
  const PackedPoints packed = Pack(positions, values);
  ASSERT_EQ(packed.points.size(), positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const double at =
          packed.corner[axis] + packed.points[i][static_cast<std::size_t>(axis)] / 65535.0 * packed.size[axis];
      EXPECT_NEAR(at, positions[i][axis], 200.0 / 65535);
    }
    const float value =
        packed.scalar_lo + static_cast<float>(packed.points[i][3]) / 65535 * (packed.scalar_hi - packed.scalar_lo);
    EXPECT_NEAR(value, values[i], 200.0F / 65535);
  }
}

TEST(PackedPoints, TakeASinglePointAndValuesThatAreNoNumbers) {
  const std::vector<Eigen::Vector3d> one = {Eigen::Vector3d(1, 2, 3)};
  const std::vector<float> nothing = {std::numeric_limits<float>::quiet_NaN()};
  const PackedPoints packed = Pack(one, nothing);
  ASSERT_EQ(packed.points.size(), 1U);
  EXPECT_EQ(packed.corner, one.front());
  EXPECT_TRUE(Pack({}, {}).points.empty());
}

}  // namespace
}  // namespace hgros::viewer
