#include "viewer/data/frames/frame_ages.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace hgros::viewer {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

EdgeSnapshot Edge(const std::string& child, std::uint64_t sets, bool is_static = false) {
  EdgeSnapshot edge;
  edge.parent = "map";
  edge.child = child;
  edge.sets = sets;
  edge.is_static = is_static;
  return edge;
}

TEST(FrameAges, CountFromTheArrivalOfTheLastTransform) {
  FrameAges ages;
  ages.Update(std::vector{Edge("base", 1), Edge("lidar", 1, true)}, 10);
  EXPECT_EQ(ages.AgeOf("base", 12), 2);
  EXPECT_EQ(ages.AgeOf("lidar", 12), std::nullopt) << "it is static";
  EXPECT_EQ(ages.AgeOf("map", 12), std::nullopt) << "it has no parent";
  ages.Update(std::vector{Edge("base", 1)}, 13);
  EXPECT_EQ(ages.AgeOf("base", 14), 4) << "no transform has arrived since";
  ages.Update(std::vector{Edge("base", 2)}, 15);
  EXPECT_EQ(ages.AgeOf("base", 15.5), 0.5);
  ages.Update({}, 16);
  EXPECT_TRUE(ages.empty());
}

TEST(FrameAges, PredictTheNextFrameToReachAnAge) {
  FrameAges ages;
  ages.Update(std::vector{Edge("a", 1)}, 10);
  ages.Update(std::vector{Edge("a", 1), Edge("b", 1)}, 12);
  EXPECT_EQ(ages.NextAged(5, 12), 15);
  EXPECT_EQ(ages.NextAged(5, 15), 17) << "the first frame has already reached it";
  EXPECT_EQ(ages.NextAged(5, 17), kNever);
}

TEST(FrameAges, AreReachedExactlyAtThePredictedTime) {
  for (const double at_s : {0.1, 1234.1, 1e6 / 3, 7.7e8}) {
    for (const double age_s : {0.1, 0.3, 5.0, 59.9}) {
      FrameAges ages;
      ages.Update(std::vector{Edge("a", 1)}, at_s);
      const double next_s = ages.NextAged(age_s, at_s);
      EXPECT_FALSE(ages.HasAged("a", age_s, at_s));
      EXPECT_TRUE(ages.HasAged("a", age_s, next_s)) << at_s << " and " << age_s;
      EXPECT_EQ(ages.NextAged(age_s, next_s), kNever);
    }
  }
  EXPECT_FALSE(FrameAges().HasAged("a", 0, 1));
}

}  // namespace
}  // namespace hgros::viewer
