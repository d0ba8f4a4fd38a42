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

/// A JumpWatch of an edge whose newest stamp, of publisher 1, is at 100 s.
class Watched {
 public:
  Watched() { watch.Begin(PublisherId{1}); }
  /// A stamp comes `after_ms` after the begin.
  bool HasJumped(std::int64_t after_ms, std::int64_t stamp_s, std::uint32_t publisher = 1) {
    constexpr std::int64_t kSecond = 1'000'000'000;
    return watch.HasJumped(100 * kSecond, stamp_s * kSecond, PublisherId{publisher},
                           JumpWatch::Moment() + std::chrono::milliseconds(after_ms));
  }
  JumpWatch watch;
};

TEST(JumpWatch, LateTransformsAndBundlesAreNoJump) {
  Watched edge;
  EXPECT_FALSE(edge.HasJumped(0, 10));
  EXPECT_FALSE(edge.HasJumped(900, 59));
  EXPECT_FALSE(edge.HasJumped(1800, 60)) << "a bundle";
  edge.watch.Begin(PublisherId{1});  // A newer one.
  EXPECT_FALSE(edge.HasJumped(2100, 61));
  EXPECT_FALSE(edge.HasJumped(3000, 62));
  EXPECT_FALSE(edge.HasJumped(3900, 63));
  EXPECT_FALSE(edge.HasJumped(4200, 60)) << "they descend";
  EXPECT_FALSE(edge.HasJumped(5100, 61));
  EXPECT_FALSE(edge.HasJumped(6000, 62));
  EXPECT_FALSE(edge.HasJumped(6300, 99)) << "slightly late";
  EXPECT_FALSE(edge.HasJumped(6400, 50));
  EXPECT_FALSE(edge.HasJumped(7300, 50));
  EXPECT_FALSE(edge.HasJumped(8200, 50));
  EXPECT_TRUE(edge.HasJumped(8400, 50));
}

TEST(JumpWatch, TwoLateTransformsWithNothingBetweenAreNoJump) {
  Watched edge;
  EXPECT_FALSE(edge.HasJumped(0, 10));
  EXPECT_FALSE(edge.HasJumped(2500, 20));
  EXPECT_FALSE(edge.HasJumped(3400, 30));
  EXPECT_FALSE(edge.HasJumped(4300, 40));
  EXPECT_TRUE(edge.HasJumped(4500, 40)) << "2 s after the second one";
}

TEST(JumpWatch, StampsOfAnotherPublisherAreNoJump) {
  Watched edge;
  for (int i = 0; i < 50; ++i) EXPECT_FALSE(edge.HasJumped(100 * i, i, 2));
  EXPECT_FALSE(edge.HasJumped(5000, 50));
  EXPECT_FALSE(edge.HasJumped(5900, 51));
  EXPECT_FALSE(edge.HasJumped(6800, 52, 2));
  EXPECT_FALSE(edge.HasJumped(7100, 53)) << "both publish";
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
