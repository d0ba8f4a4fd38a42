#include <gtest/gtest.h>

#include <chrono>
#include <limits>
#include <vector>

#include "viewer/data/frames/fixed_frame.hpp"
#include "viewer/data/frames/frame_ages.hpp"
#include "viewer/data/frames/pose_list.hpp"

namespace hgros::viewer {
namespace {

using Answer = FixedFrame::Answer;

constexpr Time kNow{5'000'000'000};

class FixedFrameTest : public ::testing::Test {
 protected:
  TransformTree tree_;
  FixedFrame frame_{tree_};
  RigidTransform place_;
  std::string why_;
};

TEST_F(FixedFrameTest, IsTheFirstMessagesFrameWhileThereAreNoTransforms) {
  EXPECT_FALSE(frame_.Refresh());
  EXPECT_TRUE(frame_.Saw("laser"));
  EXPECT_FALSE(frame_.Saw("camera"));
  EXPECT_EQ(frame_.Find("laser", kNow, place_, why_), Answer::kFound);
  EXPECT_EQ(frame_.Find("", kNow, place_, why_), Answer::kFound);
  EXPECT_EQ(frame_.Find("camera", kNow, place_, why_), Answer::kLater);
  EXPECT_NE(why_, "");
}

TEST_F(FixedFrameTest, IsTheRootOfTheTransformsAndFollowsANewRoot) {
  tree_.Set("odom", "base", kNow, RigidTransform());
  EXPECT_TRUE(frame_.Refresh());
  EXPECT_EQ(frame_.name(), "odom");
  tree_.Set("map", "odom", kNow, RigidTransform());
  EXPECT_TRUE(frame_.Refresh());
  EXPECT_EQ(frame_.name(), "map");
  EXPECT_FALSE(frame_.Refresh());
}

TEST_F(FixedFrameTest, PrefersUsualNamesAmongRoots) {
  tree_.SetStatic("a", "b", RigidTransform());
  tree_.SetStatic("b", "c", RigidTransform());
  tree_.SetStatic("map", "d", RigidTransform());
  EXPECT_TRUE(frame_.Refresh());
  EXPECT_EQ(frame_.name(), "map");
}

TEST_F(FixedFrameTest, KeepsTheRequestedFrame) {
  tree_.SetStatic("map", "base", RigidTransform());
  frame_.Ask("base");
  EXPECT_FALSE(frame_.Refresh());
  EXPECT_EQ(frame_.name(), "base");
  frame_.Ask("");
  EXPECT_TRUE(frame_.Refresh());
  EXPECT_EQ(frame_.name(), "map");
}

TEST_F(FixedFrameTest, ReportsWhetherATransformMayStillArrive) {
  tree_.Set("map", "base", kNow, RigidTransform());
  (void)frame_.Refresh();
  EXPECT_EQ(frame_.Find("base", kNow, place_, why_), Answer::kFound);
  EXPECT_EQ(frame_.Find("base", Time{}, place_, why_), Answer::kFound) << "no stamp: the latest";
  EXPECT_EQ(frame_.Find("base", kNow + std::chrono::seconds(1), place_, why_), Answer::kLater);
  EXPECT_EQ(frame_.Find("base", kNow - std::chrono::seconds(1), place_, why_), Answer::kNever);
}

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

std::vector<RigidTransform> Line(int count) {
  std::vector<RigidTransform> poses;
  for (int i = 0; i < count; ++i) poses.push_back({{1, 0, 0, 0}, {500'000.0 + i, 0, 0}});
  return poses;
}

TEST(PoseList, DistinguishesGrownFromRewrittenTrajectories) {
  PoseList list;
  EXPECT_EQ(list.Replace(Line(3)), PoseList::Change::kAppended);
  EXPECT_EQ(list.Replace(Line(3)), PoseList::Change::kNothing);
  EXPECT_EQ(list.Replace(Line(5)), PoseList::Change::kAppended);
  auto bent = Line(6);
  bent[1].translation.y() = 0.5;
  EXPECT_EQ(list.Replace(bent), PoseList::Change::kRewritten);
  EXPECT_EQ(list.poses().size(), 6U);
  EXPECT_FLOAT_EQ(list.poses()[1].position.y(), 0.5F);
  EXPECT_EQ(list.Replace(Line(2)), PoseList::Change::kRewritten);
  EXPECT_EQ(list.Replace({}), PoseList::Change::kRewritten);
  EXPECT_EQ(list.Replace({}), PoseList::Change::kNothing);
}

TEST(PoseList, IsRelativeToItsFirstPose) {
  PoseList list;
  (void)list.Replace(Line(2));
  EXPECT_EQ(list.origin().x(), 500'000);
  EXPECT_EQ(list.poses()[1].position.x(), 1);
}

TEST(PoseList, OmitsPosesThatAreNotNumbers) {
  auto poses = Line(3);
  poses[0].translation.x() = std::numeric_limits<double>::quiet_NaN();
  PoseList list;
  (void)list.Replace(poses);
  EXPECT_EQ(list.poses().size(), 2U);
  EXPECT_EQ(list.left_out(), 1U);
}

TEST(PoseList, KeepsTheLastPosesOfATrail) {
  PoseList list;
  for (const RigidTransform& pose : Line(5)) (void)list.Append(pose);
  EXPECT_EQ(list.KeepLast(5), PoseList::Change::kNothing);
  EXPECT_EQ(list.KeepLast(2), PoseList::Change::kRewritten);
  EXPECT_EQ(list.poses().front().position.x(), 3);
}

}  // namespace
}  // namespace hgros::viewer
