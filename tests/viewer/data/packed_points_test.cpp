#include "viewer/data/packed_points.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <span>
#include <vector>

namespace hgros::viewer {
namespace {

struct Packed {
  PackedBox box;
  std::vector<PackedPoint> points;
};

Packed PackAll(std::span<const Eigen::Vector3d> positions, std::span<const float> values) {
  Packed packed{BoxAround(positions, values), std::vector<PackedPoint>(positions.size())};
  Pack(positions, values, packed.box, packed.points);
  return packed;
}

TEST(PackedPoints, KeepPositionsAndValuesWithinAStep) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> metres(-100, 100);
  std::vector<Eigen::Vector3d> positions(500);
  std::vector<float> values(500);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    positions[i] = Eigen::Vector3d(metres(random) + 1e6, metres(random), metres(random));
    values[i] = static_cast<float>(metres(random));
  }
  const auto [box, points] = PackAll(positions, values);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const double at = box.corner[axis] + points[i][static_cast<std::size_t>(axis)] / 65535.0 * box.size[axis];
      EXPECT_NEAR(at, positions[i][axis], 200.0 / 65535);
    }
    const float value = box.scalar_lo + static_cast<float>(points[i][3]) / 65535 * (box.scalar_hi - box.scalar_lo);
    EXPECT_NEAR(value, values[i], 200.0F / 65535);
  }
}

TEST(PackedPoints, TakeASinglePointAndValuesThatAreNoNumbers) {
  const std::vector<Eigen::Vector3d> one = {Eigen::Vector3d(1, 2, 3)};
  const std::vector<float> nothing = {std::numeric_limits<float>::quiet_NaN()};
  const auto [box, points] = PackAll(one, nothing);
  ASSERT_EQ(points.size(), 1U);
  EXPECT_EQ(box.corner, one.front());
  EXPECT_TRUE(PackAll({}, {}).points.empty());
}

}  // namespace
}  // namespace hgros::viewer
