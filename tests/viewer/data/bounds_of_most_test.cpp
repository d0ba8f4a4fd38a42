#include "viewer/data/bounds_of_most.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace hgros::viewer {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

AlignedBox3d Cube(const Vector3d& center, double side) {
  return {center - Vector3d::Constant(side / 2), center + Vector3d::Constant(side / 2)};
}

TEST(BoundsOfMost, ContainsEverythingThatIsNear) {
  EXPECT_TRUE(BoundsOfMost({}).isEmpty());
  EXPECT_TRUE(BoundsOfMost({AlignedBox3d()}).isEmpty());
  const AlignedBox3d box = BoundsOfMost({Cube({0, 0, 0}, 2), AlignedBox3d(), Cube({90'000, 0, 0}, 4)});
  EXPECT_EQ(box.min(), Vector3d(-1, -2, -2));
  EXPECT_EQ(box.max(), Vector3d(90'002, 2, 2));
}

TEST(BoundsOfMost, LeavesOutASingleMalformedBox) {
  const double nan = std::nan("");
  const AlignedBox3d bad[] = {
      Cube({0, 0, 0}, 1e9),
      Cube({3e7, 0, 0}, 1),
      Cube({0, -1e308, 0}, 1),
      Cube({0, -1e30, 0}, 1),
      Cube({-3e7, 0, 0}, 1),
      Cube({0, 0, 0}, std::numeric_limits<double>::infinity()),
      {Vector3d(0, nan, 0), Vector3d(1, nan, 1)},
  };
  for (const AlignedBox3d& one : bad) {
    for (const std::size_t others : {1U, 2U, 5U}) {
      std::vector<AlignedBox3d> boxes(others, Cube({5e6, 1, 2}, 3));
      boxes.insert(boxes.begin() + static_cast<std::ptrdiff_t>(others / 2), one);
      const AlignedBox3d box = BoundsOfMost(boxes);
      EXPECT_TRUE(box.isApprox(Cube({5e6, 1, 2}, 3))) << one.min().transpose() << " beside " << others;
    }
  }
}

TEST(BoundsOfMost, ContainsAllOfALargeWorld) {
  std::vector<AlignedBox3d> satellites;
  for (int i = 0; i < 12; ++i) {
    satellites.push_back(Cube(2e7 * Vector3d(std::cos(0.5 * i), std::sin(0.5 * i), 0), 10));
  }
  const AlignedBox3d box = BoundsOfMost(satellites);
  EXPECT_GT(box.sizes().x(), 3.9e7);
  EXPECT_GT(box.sizes().y(), 3.9e7);
  EXPECT_EQ(BoundsOfMost({Cube({0, 0, 0}, 1e9)}).sizes().x(), 1e9) << "there is nothing else";
}

}  // namespace
}  // namespace hgros::viewer
