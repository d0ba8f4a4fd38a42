#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "viewer/scene/displays/placement.hpp"
#include "viewer/scene/displays/settling.hpp"

namespace hgros::viewer {
namespace {

class PlacementTest : public ::testing::Test {
 protected:
  bool Follow(const std::string& name, bool transforms_changed = true, bool frame_changed = false) {
    return placement_.Follow(name, {frame_, now_s_, frame_changed, transforms_changed});
  }
  void Set(double x) { tree_.Set("map", "base", Time{++stamps_}, RigidTransform({1, 0, 0, 0}, {x, 0, 0})); }

  TransformTree tree_;
  FixedFrame frame_{tree_};
  Placement placement_;
  std::int64_t stamps_ = 0;
  double now_s_ = 0;
};

TEST_F(PlacementTest, ChangesOnlyWhenTheFrameMoves) {
  frame_.Ask("map");
  Set(1);
  EXPECT_TRUE(Follow("base"));
  EXPECT_FALSE(Follow("base"));
  Set(1);
  EXPECT_FALSE(Follow("base"));
  Set(2);
  EXPECT_FALSE(Follow("base", false));
  EXPECT_TRUE(Follow("base"));
  EXPECT_EQ(placement_.T_fixed_frame().translation.x(), 2);
  EXPECT_TRUE(Follow("map"));
}

TEST_F(PlacementTest, ReportsATransformThatIsMissingForAWhileUntilItArrives) {
  frame_.Ask("map");
  tree_.SetStatic("map", "other", RigidTransform());
  EXPECT_FALSE(Follow("base"));
  EXPECT_FALSE(placement_.known());
  EXPECT_EQ(placement_.fault(), "") << "it may still come";
  EXPECT_THAT(placement_.waits_for(), ::testing::HasSubstr("base"));
  EXPECT_EQ(placement_.next_change_s(), kLongestWaitS);
  now_s_ = kLongestWaitS;
  EXPECT_FALSE(Follow("base", false));
  EXPECT_THAT(placement_.fault(), ::testing::HasSubstr("base"));
  EXPECT_EQ(placement_.waits_for(), "");
  EXPECT_GT(placement_.next_change_s(), 1e9) << "nothing changes by itself any more";
  Set(1);
  EXPECT_TRUE(Follow("base"));
  EXPECT_EQ(placement_.fault(), "");
}

TEST_F(PlacementTest, CountsTheWaitOfEachLossAnew) {
  frame_.Ask("map");
  Set(1);
  EXPECT_TRUE(Follow("base"));
  now_s_ = 10;
  EXPECT_FALSE(Follow("nowhere"));
  EXPECT_EQ(placement_.fault(), "");
  EXPECT_EQ(placement_.next_change_s(), 10 + kLongestWaitS);
}

TEST_F(PlacementTest, IsFoundAgainInANewFixedFrame) {
  frame_.Ask("map");
  Set(1);
  EXPECT_TRUE(Follow("base"));
  frame_.Ask("base");
  EXPECT_TRUE(Follow("base", false, true));
  EXPECT_EQ(placement_.T_fixed_frame().translation.x(), 0);
}

TEST_F(PlacementTest, MakesTheFirstFrameTheFixedOneWithoutTransforms) {
  EXPECT_TRUE(Follow("camera"));
  EXPECT_EQ(frame_.name(), "camera");
}

TEST(Settling, SettlesAtOnceAndDrawsTheFirstMessageOnce) {
  Settling settling;
  EXPECT_FALSE(settling.TakeNew());
  EXPECT_FALSE(settling.TakeSettled());
  EXPECT_EQ(settling.Replaced(0), Change::kAppended);
  EXPECT_TRUE(settling.TakeNew());
  EXPECT_FALSE(settling.TakeNew());
  EXPECT_TRUE(settling.TakeSettled());
  EXPECT_FALSE(settling.moves());
}

TEST(Settling, MovesUntilItHasNotBeenReplacedForAWhile) {
  Settling settling;
  EXPECT_EQ(settling.Replaced(0), Change::kAppended);
  EXPECT_EQ(settling.Replaced(1), Change::kRedraw);
  EXPECT_TRUE(settling.moves());
  EXPECT_EQ(settling.next_change_s(), 3);
  EXPECT_EQ(settling.Replaced(2), Change::kMoving);
  EXPECT_FALSE(settling.TakeNew());
  EXPECT_FALSE(settling.TakeSettled());
  EXPECT_EQ(settling.Rest(3.9), Change::kNothing);
  EXPECT_EQ(settling.Rest(4), Change::kAppended);
  EXPECT_TRUE(settling.settled());
  EXPECT_TRUE(settling.TakeNew());
}

TEST(Settling, StartsAgainAfterItWasRemoved) {
  Settling settling;
  EXPECT_EQ(settling.Gone(), Change::kMoving);
  EXPECT_EQ(settling.Replaced(0), Change::kAppended);
  EXPECT_EQ(settling.Gone(), Change::kRedraw);
  EXPECT_FALSE(settling.TakeSettled());
  EXPECT_EQ(settling.Replaced(1), Change::kAppended);
}

}  // namespace
}  // namespace hgros::viewer
