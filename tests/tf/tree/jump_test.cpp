#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdint>

#include "hgros/tf/transform_tree.hpp"
#include "support/await.hpp"
#include "tf/tf_fixture.hpp"
#include "tf/tree/jump_watch.hpp"

namespace hgros::tf::jump_test {
namespace {

using test::Await;
using test::Difference;
using test::Shift;

Time At(double seconds) { return Time{static_cast<std::int64_t>(std::llround(seconds * 1e9))}; }

TEST(JumpWatch, LateTransformsAndBundlesAreNoJump) {
  using std::chrono::milliseconds;
  constexpr std::int64_t kSecond = 1'000'000'000;
  JumpWatch watch;
  const JumpWatch::Moment begin{};
  EXPECT_FALSE(watch.HasJumped(100 * kSecond, 10 * kSecond, begin));
  EXPECT_FALSE(watch.HasJumped(100 * kSecond, 60 * kSecond, begin + milliseconds(1900))) << "a bundle";
  watch.Reset();  // A newer one.
  EXPECT_FALSE(watch.HasJumped(100 * kSecond, 61 * kSecond, begin + milliseconds(2100)));
  EXPECT_FALSE(watch.HasJumped(100 * kSecond, 60 * kSecond, begin + milliseconds(4200))) << "they descend";
  EXPECT_FALSE(watch.HasJumped(100 * kSecond, 99 * kSecond, begin + milliseconds(6300))) << "slightly late";
  EXPECT_FALSE(watch.HasJumped(100 * kSecond, 50 * kSecond, begin + milliseconds(6400)));
  EXPECT_TRUE(watch.HasJumped(100 * kSecond, 50 * kSecond, begin + milliseconds(8400)));
}

TEST(EdgeJump, AnEdgeBeginsAgainWhenItsStampsJumpedBackAndStayThere) {
  for (const double back : {3.0, 60.0}) {  // Within the edge's buffer, and before it.
    TransformTree tree;
    ASSERT_TRUE(tree.Set("map", "base", At(100), Shift(1)));
    ASSERT_TRUE(tree.Set("map", "arm", At(100), Shift(1)));
    double stamp = 100 - back;
    EXPECT_TRUE(Await([&] { return tree.Set("map", "base", At(stamp += 1e-6), Shift(2)).jumped_back(); }));
    EXPECT_EQ(tree.Lookup("map", "base")->stamp, At(stamp));
    EXPECT_LT(Difference(tree.Lookup("map", "base")->T_target_source, Shift(2)), 1e-12);
    EXPECT_EQ(tree.Lookup("map", "arm")->stamp, At(100)) << "each edge by itself";
    EXPECT_FALSE(tree.Set("map", "base", At(stamp + 1), Shift(3)).jumped_back());
  }
}

}  // namespace
}  // namespace hgros::tf::jump_test
