#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "foxglove/Odometry.pb.h"
#include "foxglove/PoseInFrame.pb.h"
#include "foxglove/PosesInFrame.pb.h"
#include "viewer/scene/scene_fixture.hpp"

namespace hgros::viewer::test {
namespace {

void SetPose(foxglove::Pose& pose, double x, double y, double heading) {
  pose.mutable_position()->set_x(x);
  pose.mutable_position()->set_y(y);
  pose.mutable_orientation()->set_z(std::sin(heading / 2));
  pose.mutable_orientation()->set_w(std::cos(heading / 2));
}

foxglove::PosesInFrame Wave(int count, double bend = 0) {
  foxglove::PosesInFrame poses;
  poses.set_frame_id("map");
  for (int i = 0; i < count; ++i) {
    const double x = 0.25 * i - 6;
    SetPose(*poses.add_poses(), x, 2 * std::sin(0.6 * x) + bend * x, std::atan(1.2 * std::cos(0.6 * x) + bend));
  }
  return poses;
}

class PoseDisplaysTest : public SceneTest {};

TEST_F(PoseDisplaysTest, DrawsATrajectoryAsALine) {
  Add("Ground");
  Add("Trajectory", "way", {"style", "line", "width", "3"});
  Publish("way", Wave(48));
  Update();
  ExpectAsKept("trajectory_line");
}

TEST_F(PoseDisplaysTest, DrawsATrajectoryAsAxes) {
  Add("Ground");
  Add("Trajectory", "way", {"style", "both", "axes length", "0.6"});
  Publish("way", Wave(48));
  Update();
  ExpectAsKept("trajectory_axes");
}

TEST_F(PoseDisplaysTest, WaitsAgainForATransformAfterAnEmptyMessage) {
  Display& display = Add("Trajectory", "way");
  tree_.SetStatic("map", "other", RigidTransform());
  foxglove::PosesInFrame way = Wave(3);
  way.set_frame_id("lidar");
  Publish("way", way);
  Update(0);
  Update(2);
  EXPECT_TRUE(display.HasFault());
  foxglove::PosesInFrame empty;
  empty.set_frame_id("lidar");
  Publish("way", empty);
  Update(3);
  EXPECT_FALSE(display.HasFault()) << display.Status().front();
  Publish("way", way);
  Update(10);
  EXPECT_FALSE(display.HasFault()) << "the transform may still come";
  EXPECT_THAT(display.WaitsFor(), ::testing::HasSubstr("lidar"));
  Update(12);
  EXPECT_TRUE(display.HasFault());
}

TEST_F(PoseDisplaysTest, PosesAddedOneByOneLookLikeAllAtOnce) {
  Add("Trajectory", "way", {"style", "both"});
  for (int i = 1; i <= 48; ++i) {
    Publish("way", Wave(i));
    Update();
    (void)Draw();
  }
  const Pixels grown = Draw();
  scene_.Redraw();
  EXPECT_LT(DifferentShare(grown, Draw()), 0.002);
}

TEST_F(PoseDisplaysTest, LeavesNothingOfARewrittenTrajectory) {
  Add("Trajectory", "way");
  Publish("way", Wave(48));
  Update(0);
  (void)Draw();
  Publish("way", Wave(48, 0.3));
  Update(1);
  const Pixels rewritten = Draw();
  Update(10);  // After a rest it is settled again.
  const Pixels settled = Draw();
  scene_.Remove(0);
  Add("Trajectory", "way");
  Publish("way", Wave(48, 0.3));
  Update(11);
  const Pixels fresh = Draw();
  EXPECT_LT(DifferentShare(rewritten, fresh), 0.002);
  EXPECT_LT(DifferentShare(settled, fresh), 0.002);
}

TEST_F(PoseDisplaysTest, PosesInAnotherFrameMoveWithIt) {
  Add("Trajectory", "way");
  tree_.Set("map", "odom", Time{1}, RigidTransform());
  foxglove::PosesInFrame poses = Wave(48);
  poses.set_frame_id("odom");
  Publish("way", poses);
  Update(0);
  const Pixels before = Draw();
  tree_.Set("map", "odom", Time{2}, RigidTransform({1, 0, 0, 0}, {0, 3, 0}));
  transforms_changed_ = true;
  Update(1);
  const Pixels after = Draw();
  EXPECT_GT(DifferentShare(before, after), 0.005);
  tree_.Set("map", "odom", Time{3}, RigidTransform());
  transforms_changed_ = true;
  Update(2);
  EXPECT_LT(DifferentShare(before, Draw()), 0.002);
}

TEST_F(PoseDisplaysTest, DrawsASinglePoseMessage) {
  Add("Ground");
  Add("Pose", "pose", {"axes length", "3"});
  foxglove::PoseInFrame pose;
  pose.set_frame_id("map");
  SetPose(*pose.mutable_pose(), 1, 1, 0.5);
  Publish("pose", pose);
  Update();
  ExpectAsKept("pose");
}

TEST_F(PoseDisplaysTest, DrawsOdometryLikeAPose) {
  Add("Ground");
  Display& display = Add("Odometry", "odometry", {"axes length", "3"});
  foxglove::Odometry odometry;
  odometry.set_frame_id("map");
  odometry.set_body_frame_id("base");
  SetPose(*odometry.mutable_pose(), 1, 1, 0.5);
  Publish("odometry", odometry);
  Update();
  ExpectAsKept("pose");
  EXPECT_EQ(display.data_frame(), "map");
  EXPECT_EQ(DisplayTypeFor("foxglove.Odometry"), DisplayTypeNamed("Odometry"));
}

TEST_F(PoseDisplaysTest, DrawsFramesWithLinksAndNames) {
  Add("Ground");
  Display& frames = Add("Frames", "", {"axes length", "1"});
  tree_.Set("map", "base", Time{1}, RigidTransform({1, 0, 0, 0}, {3, 1, 0}));
  tree_.SetStatic(
      "base", "lidar",
      RigidTransform(RigidTransform::Rotation(Eigen::AngleAxisd(0.8, Eigen::Vector3d::UnitX())), {0, 0, 2}));
  Update();
  ExpectAsKept("frames");
  std::vector<std::string> names;
  for (const Label& label : frames.Labels()) names.push_back(label.text);
  EXPECT_THAT(names, ::testing::UnorderedElementsAre("map", "base", "lidar"));
}

std::vector<std::string> TextsOf(const Display& display) {
  std::vector<std::string> texts;
  for (const Label& label : display.Labels()) texts.push_back(label.text);
  return texts;
}

TEST_F(PoseDisplaysTest, ShowsSilentFramesInOrange) {
  Display& frames = Add("Frames");
  tree_.Set("map", "base", Time{1}, RigidTransform({1, 0, 0, 0}, {3, 1, 0}));
  tree_.SetStatic("base", "lidar", RigidTransform());
  Update(100);
  EXPECT_THAT(TextsOf(frames), ::testing::UnorderedElementsAre("map", "base", "lidar"));
  EXPECT_DOUBLE_EQ(scene_.next_change_s(), 105) << "the time at which it becomes silent";
  Update(104);
  EXPECT_THAT(TextsOf(frames), ::testing::Contains("base"));
  Update(105);
  EXPECT_THAT(TextsOf(frames), ::testing::UnorderedElementsAre("map", "base (silent)", "lidar"));
  EXPECT_THAT(frames.Status(), ::testing::Contains("base: below map, silent"));
  EXPECT_THAT(frames.Status(), ::testing::Contains("lidar: below base, static"));
  EXPECT_EQ(scene_.next_change_s(), std::numeric_limits<double>::infinity()) << "it causes no further drawing";
  tree_.Set("map", "base", Time{2}, RigidTransform());
  transforms_changed_ = true;
  Update(110);
  EXPECT_THAT(TextsOf(frames), ::testing::Contains("base"));
}

TEST_F(PoseDisplaysTest, UpdatesFrameAgesOnceASecondIfEnabled) {
  Display& frames = Add("Frames", "", {"ages", "on"});
  tree_.Set("map", "base", Time{1}, RigidTransform());
  Update(100.5);
  EXPECT_THAT(TextsOf(frames), ::testing::Contains("base, under 1 s"));
  EXPECT_DOUBLE_EQ(scene_.next_change_s(), 101);
  Update(103.6);
  EXPECT_THAT(TextsOf(frames), ::testing::Contains("base, 3 s"));
  EXPECT_DOUBLE_EQ(scene_.next_change_s(), 104);
  EXPECT_THAT(frames.Status(), ::testing::Contains(::testing::EndsWith(", 3 s ago")));
  Update(104.1);
  Update(105);
  EXPECT_DOUBLE_EQ(scene_.next_change_s(), 105.5) << "it becomes silent before the second is over";
  SetStandingStill(frames, "names", "off");
  Update(105.2);
  EXPECT_DOUBLE_EQ(scene_.next_change_s(), 105.5);
  Update(105.5);
  EXPECT_EQ(scene_.next_change_s(), std::numeric_limits<double>::infinity()) << "no age is shown";
}

TEST_F(PoseDisplaysTest, FramesHaveNoRateBeforeTheSecondTransform) {
  Display& frames = Add("Frames", "", {"ages", "on"});
  tree_.Set("map", "base", Time{1'000'000'000}, RigidTransform());
  Update(100);
  EXPECT_THAT(frames.Status(), ::testing::Contains("base: below map, under 1 s ago"));
  tree_.Set("map", "base", Time{2'000'000'000}, RigidTransform());
  transforms_changed_ = true;
  Update(101);
  EXPECT_THAT(frames.Status(), ::testing::Contains("base: below map, 1.00 Hz, under 1 s ago"));
}

TEST_F(PoseDisplaysTest, FramesUpdatedWhileLookingBackAreNotSilent) {
  Display& frames = Add("Frames");
  for (int second = 1; second <= 2; ++second) tree_.Set("map", "base", Time{second * 1'000'000'000LL}, {});
  Update(100);
  scene_.LookBack(100, 0.5);
  for (int second = 3; second <= 62; ++second) tree_.Set("map", "base", Time{second * 1'000'000'000LL}, {});
  scene_.LookBack(100, 0);
  transforms_changed_ = true;
  Update(160);
  EXPECT_THAT(TextsOf(frames), ::testing::UnorderedElementsAre("map", "base"));
  EXPECT_THAT(frames.Status(), ::testing::Contains("base: below map, 1.00 Hz"));
  EXPECT_DOUBLE_EQ(scene_.next_change_s(), 165) << "transforms of a pause count from its end";
}

TEST_F(PoseDisplaysTest, ShowsPastFrameAgesWhilePaused) {
  Display& frames = Add("Frames");
  tree_.Set("map", "base", Time{1}, RigidTransform());
  Update(100);
  Update(103);
  (void)Draw();
  tree_.Set("map", "other", Time{2}, RigidTransform());
  SetStandingStill(frames, "ages", "on");
  EXPECT_TRUE(scene_.pending());
  EXPECT_THAT(TextsOf(frames), ::testing::UnorderedElementsAre("map", "base, 3 s")) << "no new message is taken in";
  EXPECT_THAT(frames.Status(), ::testing::Contains(::testing::EndsWith(", 3 s ago")));
  SetStandingStill(frames, "silent after", "2");
  EXPECT_EQ(frames.Labels().back().color, MakeRgba(255, 178, 90));
  SetStandingStill(frames, "ages", "off");
  EXPECT_THAT(TextsOf(frames), ::testing::UnorderedElementsAre("map", "base (silent)"));
  SetStandingStill(frames, "silent after", "4");
  EXPECT_THAT(TextsOf(frames), ::testing::UnorderedElementsAre("map", "base"));
}

TEST_F(PoseDisplaysTest, PickingAFrameReturnsItsName) {
  Display& frames = Add("Frames", "", {"ages", "on"});
  tree_.Set("map", "base", Time{1}, RigidTransform({1, 0, 0, 0}, {3, 1, 0}));
  Update(100);
  EXPECT_EQ(frames.ValueAt({3, 1, 0}, 0), "base");
  SetStandingStill(frames, "ages", "off");
  Update(200);
  EXPECT_THAT(TextsOf(frames), ::testing::Contains("base (silent)"));
  EXPECT_EQ(frames.ValueAt({3, 1, 0}, 0), "base");
  EXPECT_EQ(frames.ValueAt({30, 1, 0}, 0), "");
}

TEST_F(PoseDisplaysTest, ShowsAndMovesFiveHundredFrames) {
  Display& frames = Add("Frames", "", {"axes length", "0.2"});
  const auto set = [&](int time, double height) {
    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector3d at(0.5 * (i % 25) - 6, 0.5 * static_cast<double>(i / 25) - 5, height);
      tree_.Set(i % 2 == 0 ? "map" : "frame" + std::to_string(i - 1), "frame" + std::to_string(i), Time{time},
                RigidTransform({1, 0, 0, 0}, i % 2 == 0 ? at : Eigen::Vector3d(0.5, 0, 0)));
    }
    transforms_changed_ = true;
  };
  set(1, 0);
  Update();
  EXPECT_EQ(frames.Labels().size(), 501U);
  EXPECT_THAT(frames.Status(), ::testing::Contains("501 frames"));
  EXPECT_THAT(frames.Status(), ::testing::Contains("and 450 more"));
  EXPECT_FALSE(frames.HasFault());
  const Pixels low = Draw();
  set(2, 2);
  Update();
  EXPECT_GT(DifferentShare(low, Draw()), 0.02);
}

TEST_F(PoseDisplaysTest, OmitsAndReportsPosesThatAreNotNumbers) {
  Display& display = Add("Trajectory", "way");
  foxglove::PosesInFrame poses = Wave(5);
  poses.mutable_poses(2)->mutable_position()->set_x(std::nan(""));
  Publish("way", poses);
  Update();
  (void)Draw();
  EXPECT_THAT(display.Status(), ::testing::Contains(::testing::HasSubstr("1 pose is not made of numbers")));
}

}  // namespace
}  // namespace hgros::viewer::test
