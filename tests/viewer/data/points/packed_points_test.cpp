#include "viewer/data/points/packed_points.hpp"

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

Packed PackAll(const PlacedPoints& positions, std::span<const float> values) {
  Packed packed{BoxAround(positions, values), std::vector<PackedPoint>(positions.size())};
  Pack(positions, values, packed.box, packed.points);
  return packed;
}

TEST(PackedPoints, ArePreciseToOneStep) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> meters(-100, 100);
  std::vector<Eigen::Vector3f> points(500);
  std::vector<float> values(500);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = Eigen::Vector3f(meters(random), meters(random), meters(random));
    values[i] = meters(random);
  }
  const RigidTransform far(RigidTransform::Rotation(Eigen::AngleAxisd(1, Eigen::Vector3d(1, 2, 3).normalized())),
                           {1e6, 0, -50});
  const PlacedPoints positions(points, far);
  const auto [box, packed] = PackAll(positions, values);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d placed = far * points[i].cast<double>();
    for (int axis = 0; axis < 3; ++axis) {
      const double at = box.corner[axis] + packed[i][static_cast<std::size_t>(axis)] / 65535.0 * box.size[axis];
      EXPECT_NEAR(at, placed[axis], 350.0 / 65535);
    }
    const float value = box.scalar_lo + static_cast<float>(packed[i][3]) / 65535 * (box.scalar_hi - box.scalar_lo);
    EXPECT_NEAR(value, values[i], 200.0F / 65535);
  }
}

TEST(PackedPoints, AcceptASinglePointAndValuesThatAreNotNumbers) {
  const std::vector<Eigen::Vector3f> one = {Eigen::Vector3f(1, 2, 3)};
  const std::vector<float> nothing = {std::numeric_limits<float>::quiet_NaN()};
  const auto [box, points] = PackAll({one, {}}, nothing);
  ASSERT_EQ(points.size(), 1U);
  EXPECT_EQ(box.corner, Eigen::Vector3d(1, 2, 3));
  EXPECT_TRUE(PackAll({{}, {}}, {}).points.empty());
}

}  // namespace
}  // namespace hgros::viewer
