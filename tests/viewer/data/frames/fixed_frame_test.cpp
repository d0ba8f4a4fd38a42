#include "viewer/data/frames/fixed_frame.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

namespace hgros::viewer {
namespace {

using Answer = FixedFrame::Answer;
constexpr Time kNow{5'000'000'000};

TEST(FixedFrame, IsTheFirstMessagesFrameWhileThereAreNoTransforms) {
  const TransformTree tree;
  FixedFrame frame(tree);
  EXPECT_FALSE(frame.Refresh());
  EXPECT_TRUE(frame.Saw("laser"));
  EXPECT_FALSE(frame.Saw("camera"));
  RigidTransform T;
  std::string why;
  EXPECT_EQ(frame.Find("laser", kNow, T, why), Answer::kFound);
  EXPECT_EQ(frame.Find("", kNow, T, why), Answer::kFound);
  EXPECT_EQ(frame.Find("camera", kNow, T, why), Answer::kLater);
  EXPECT_NE(why, "");
}

TEST(FixedFrame, IsTheRootOfTheTransformsAndFollowsANewRoot) {
  TransformTree tree;
  FixedFrame frame(tree);
  tree.Set("odom", "base", kNow, RigidTransform());
  EXPECT_TRUE(frame.Refresh());
  EXPECT_EQ(frame.name(), "odom");
  tree.Set("map", "odom", kNow, RigidTransform());
  EXPECT_TRUE(frame.Refresh());
  EXPECT_EQ(frame.name(), "map");
  EXPECT_FALSE(frame.Refresh());
}

TEST(FixedFrame, PrefersUsualNamesAmongRoots) {
  TransformTree tree;
  tree.SetStatic("a", "b", RigidTransform());
  tree.SetStatic("b", "c", RigidTransform());
  tree.SetStatic("map", "d", RigidTransform());
  FixedFrame frame(tree);
  EXPECT_TRUE(frame.Refresh());
  EXPECT_EQ(frame.name(), "map");
}

TEST(FixedFrame, KeepsTheRequestedFrame) {
  TransformTree tree;
  tree.SetStatic("map", "base", RigidTransform());
  FixedFrame frame(tree);
  frame.Ask("base");
  EXPECT_FALSE(frame.Refresh());
  EXPECT_EQ(frame.name(), "base");
  frame.Ask("");
  EXPECT_TRUE(frame.Refresh());
  EXPECT_EQ(frame.name(), "map");
}

TEST(FixedFrame, ReportsWhetherATransformMayStillArrive) {
  TransformTree tree;
  tree.Set("map", "base", kNow, RigidTransform());
  FixedFrame frame(tree);
  (void)frame.Refresh();
  RigidTransform T;
  std::string why;
  EXPECT_EQ(frame.Find("base", kNow, T, why), Answer::kFound);
  EXPECT_EQ(frame.Find("base", Time{}, T, why), Answer::kFound) << "no stamp: the latest";
  EXPECT_EQ(frame.Find("base", kNow + std::chrono::seconds(1), T, why), Answer::kLater);
  EXPECT_EQ(frame.Find("base", kNow - std::chrono::seconds(1), T, why), Answer::kNever);
}

}  // namespace
}  // namespace hgros::viewer
