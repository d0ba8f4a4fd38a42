#include "viewer/scene/blending_order.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace hgros::viewer {
namespace {

using ::testing::ElementsAre;
using Boxes = std::vector<Eigen::AlignedBox3d>;

Eigen::AlignedBox3d Box(double x, double y, double z, double size_x, double size_y, double size_z) {
  const Eigen::Vector3d lowest(x, y, z);
  return {lowest, lowest + Eigen::Vector3d(size_x, size_y, size_z)};
}

TEST(BlendingOrder, DrawsTheFrontLast) {
  const Boxes row{Box(0, 0, 0, 1, 1, 1), Box(4, 0, 0, 1, 1, 1), Box(2, 0, 0, 1, 1, 1)};
  EXPECT_THAT(BlendingOrder(row, {-10, 0, 1}), ElementsAre(1, 2, 0));
  EXPECT_THAT(BlendingOrder(row, {10, 0, 1}), ElementsAre(0, 2, 1));
}

TEST(BlendingOrder, DrawsAWideWallAfterASmallBoxBehindIt) {
  const auto wall = Box(2, -10, 0, 0.1, 20, 3);
  const auto box = Box(5, -0.5, 0, 1, 1, 1);
  EXPECT_THAT(BlendingOrder(Boxes{wall, box}, {0, 0, 1}), ElementsAre(1, 0));
  EXPECT_THAT(BlendingOrder(Boxes{wall, box}, {9, 0, 1}), ElementsAre(0, 1));
}

TEST(BlendingOrder, DrawsAMapBeforeTheRobotOnIt) {
  const auto map = Box(-20, -20, 0, 40, 40, 0.01);
  const auto robot = Box(3, 3, -0.05, 1, 1, 1);
  EXPECT_THAT(BlendingOrder(Boxes{robot, map}, {-5, -5, 8}), ElementsAre(1, 0));
  EXPECT_THAT(BlendingOrder(Boxes{map, robot}, {-5, -5, 8}), ElementsAre(0, 1));
}

TEST(BlendingOrder, EndsForBoxesThatFormARing) {
  const Boxes ring{Box(0, 0, 0, 4, 1, 1), Box(3, 0.5, 0.5, 1, 4, 1), Box(-1, 3, -1, 4.5, 1, 2.2)};
  for (double x = -10; x <= 10; x += 2.5) {
    for (double y = -10; y <= 10; y += 2.5) {
      EXPECT_EQ(BlendingOrder(ring, {x, y, 6}).size(), 3U);
    }
  }
}

TEST(BlendingOrder, KeepsTheOrderOfThingsWithoutABoxAtTheEnd) {
  const Boxes boxes{Eigen::AlignedBox3d(), Box(0, 0, 0, 1, 1, 1), Eigen::AlignedBox3d()};
  EXPECT_THAT(BlendingOrder(boxes, {5, 5, 5}), ElementsAre(1, 0, 2));
  EXPECT_TRUE(BlendingOrder({}, {0, 0, 0}).empty());
}

}  // namespace
}  // namespace hgros::viewer
