#include "viewer/data/shapes/polygon_triangles.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "support/seed.hpp"

namespace hgros::viewer {
namespace {

using Corners = std::vector<Eigen::Vector2d>;

double Area(const Corners& corners) {
  double twice = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const auto &a = corners[i], &b = corners[(i + 1) % corners.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return twice / 2;
}

double AreaOfTriangles(const Corners& corners) {
  double sum = 0;
  for (const auto& [a, b, c] : TrianglesOf(corners)) {
    const double area = Area({corners.at(a), corners.at(b), corners.at(c)});
    EXPECT_GT(area, 0) << "counter-clockwise";
    sum += area;
  }
  return sum;
}

TEST(PolygonTriangles, CoverConvexAndConcavePolygonsInEitherDirection) {
  const Corners square{{0, 0}, {2, 0}, {2, 2}, {0, 2}};
  const Corners hook{{0, 0}, {4, 0}, {4, 4}, {3, 4}, {3, 1}, {0, 1}};
  const Corners comb{{0, 0}, {7, 0}, {7, 3}, {6, 3}, {6, 1}, {5, 1}, {5, 3}, {4, 3}, {4, 1}, {3, 1}, {3, 3}, {0, 3}};
  for (Corners corners : {square, hook, comb}) {
    EXPECT_EQ(TrianglesOf(corners).size(), corners.size() - 2);
    EXPECT_NEAR(AreaOfTriangles(corners), Area(corners), 1e-12);
    std::ranges::reverse(corners);
    EXPECT_NEAR(AreaOfTriangles(corners), -Area(corners), 1e-12);
  }
}

TEST(PolygonTriangles, CoverRandomStars) {
  std::mt19937 random(hgros::test::Seed());
  std::uniform_real_distribution<double> radius(0.1, 1);
  for (int round = 0; round < 200; ++round) {
    Corners corners;
    const int count = 3 + static_cast<int>(random() % 60);
    for (int i = 0; i < count; ++i) {
      const double angle = 2 * M_PI * i / count;
      corners.push_back(radius(random) * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    }
    ASSERT_NEAR(AreaOfTriangles(corners), Area(corners), 1e-9);
  }
}

TEST(PolygonTriangles, AcceptStraightAndRepeatedCorners) {
  const Corners square{{0, 0}, {1, 0}, {1, 0}, {2, 0}, {2, 1}, {2, 2}, {0, 2}, {0, 1}};
  EXPECT_NEAR(AreaOfTriangles(square), 4, 1e-12);
}

TEST(PolygonTriangles, AreEmptyForAPolygonWithoutArea) {
  EXPECT_TRUE(TrianglesOf({}).empty());
  EXPECT_TRUE(TrianglesOf(Corners{{0, 0}, {1, 1}}).empty());
  EXPECT_TRUE(TrianglesOf(Corners{{0, 0}, {1, 1}, {2, 2}, {3, 3}}).empty());
  EXPECT_TRUE(TrianglesOf(Corners{{0, 0}, {NAN, 1}, {2, 2}}).empty());
  EXPECT_TRUE(TrianglesOf(Corners(10'001)).empty());
}

TEST(PolygonTriangles, AreFiniteForAPolygonThatCrossesItself) {
  EXPECT_LE(TrianglesOf(Corners{{0, 0}, {2, 2}, {2, 0}, {0, 2}}).size(), 2U);
}

}  // namespace
}  // namespace hgros::viewer
