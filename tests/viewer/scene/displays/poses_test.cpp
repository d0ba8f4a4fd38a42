#include <gmock/gmock.h>

#include <cmath>

#include "foxglove/Odometry.pb.h"
#include "foxglove/PoseInFrame.pb.h"
#include "foxglove/PosesInFrame.pb.h"
#include "viewer/e2e/message_parts.hpp"
#include "viewer/scene/scene_fixture.hpp"

namespace hgros::viewer::test {
namespace {

using ::testing::Contains;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;

void SetHeadedPose(foxglove::Pose& pose, double x, double y, double heading) {
  SetPose(pose, {RigidTransform::Rotation(Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ())), {x, y, 0}});
}

foxglove::PosesInFrame Wave(int count, double bend = 0) {
  foxglove::PosesInFrame poses;
  poses.set_frame_id("map");
  for (int i = 0; i < count; ++i) {
    const double x = 0.25 * i - 6;
    SetHeadedPose(*poses.add_poses(), x, 2 * std::sin(0.6 * x) + bend * x, std::atan(1.2 * std::cos(0.6 * x) + bend));
  }
  return poses;
}

class PoseDisplaysTest : public SceneTest {
 protected:
  static std::vector<std::string> TextsOf(const Display& display) {
    std::vector<std::string> texts;
    for (const Label& label : display.Labels()) texts.push_back(label.text);
    return texts;
  }
};

TEST_F(PoseDisplaysTest, DrawsATrajectoryAsALineOrAxes) {
  Add("Ground");
  Show("Trajectory", "way", Wave(48), {"style", "line", "width", "3"});
  ExpectAsKept("trajectory_line");
  scene_.Remove(1);
  Show("Trajectory", "way", Wave(48), {"style", "both", "axes length", "0.6"});
  ExpectAsKept("trajectory_axes");
}

TEST_F(PoseDisplaysTest, WaitsAgainForATransformAfterAnEmptyMessage) {
  ExpectItWaitsAgainAfterAnEmptyMessage(Wave(3), foxglove::PosesInFrame(), "Trajectory");
}

TEST_F(PoseDisplaysTest, PosesAddedOneByOneLookLikeAllAtOnce) {
  Add("Trajectory", "way", {"style", "both"});
  for (int i = 1; i <= 48; ++i) {
    Send("way", Wave(i));
    (void)Draw();
  }
  const Pixels grown = Draw();
  scene_.Redraw();
  EXPECT_LT(DifferentShare(grown, Draw()), 0.002);
}

TEST_F(PoseDisplaysTest, LeavesNothingOfARewrittenTrajectory) {
  ExpectNothingLeftOf(Wave(48), Wave(48, 0.3), 0.002, "Trajectory");
}

TEST_F(PoseDisplaysTest, PosesInAnotherFrameMoveWithIt) { ExpectItMovesWithItsFrame(Wave(48), 0.005, "Trajectory"); }

TEST_F(PoseDisplaysTest, DrawsAPoseAndOdometryAlike) {
  Add("Ground");
  foxglove::PoseInFrame pose;
  pose.set_frame_id("map");
  SetHeadedPose(*pose.mutable_pose(), 1, 1, 0.5);
  Show("Pose", "pose", pose, {"axes length", "3"});
  ExpectAsKept("pose");
  scene_.Remove(1);
  foxglove::Odometry odometry;
  odometry.set_frame_id("map");
  odometry.set_body_frame_id("base");
  *odometry.mutable_pose() = pose.pose();
  Display& display = Show("Odometry", "odometry", odometry, {"axes length", "3"});
  ExpectAsKept("pose");
  EXPECT_EQ(display.data_frame(), "map");
  EXPECT_EQ(DisplayTypeFor("foxglove.Odometry"), DisplayTypeNamed("Odometry"));
}

TEST_F(PoseDisplaysTest, DrawsFramesWithLinksAndNames) {
  Add("Ground");
  Display& frames = Add("Frames", "", {"axes length", "1"});
  Move("base", 1, {3, 1, 0});
  tree_.SetStatic(
      "base", "lidar",
      RigidTransform(RigidTransform::Rotation(Eigen::AngleAxisd(0.8, Eigen::Vector3d::UnitX())), {0, 0, 2}));
  Update();
  ExpectAsKept("frames");
  EXPECT_THAT(TextsOf(frames), UnorderedElementsAre("map", "base", "lidar"));
}

TEST_F(PoseDisplaysTest, ShowsSilentFramesInOrange) {
  Display& frames = Add("Frames");
  Move("base", 1, {3, 1, 0});
  tree_.SetStatic("base", "lidar", RigidTransform());
  Update(100);
  EXPECT_THAT(TextsOf(frames), UnorderedElementsAre("map", "base", "lidar"));
  EXPECT_DOUBLE_EQ(scene_.next_change_s(), 105) << "the time at which it becomes silent";
  Update(104);
  EXPECT_THAT(TextsOf(frames), Contains("base"));
  Update(105);
  EXPECT_THAT(TextsOf(frames), UnorderedElementsAre("map", "base (silent)", "lidar"));
  EXPECT_THAT(frames.Status(), Contains("base: below map, silent"));
  EXPECT_THAT(frames.Status(), Contains("lidar: below base, static"));
  EXPECT_EQ(scene_.next_change_s(), std::numeric_limits<double>::infinity()) << "it causes no further drawing";
  Move("base", 2);
  Update(110);
  EXPECT_THAT(TextsOf(frames), Contains("base"));
}

TEST_F(PoseDisplaysTest, UpdatesFrameAgesOnceASecondIfEnabled) {
  Display& frames = Add("Frames", "", {"ages", "on"});
  Move("base", 1);
  Update(100.5);
  EXPECT_THAT(TextsOf(frames), Contains("base, under 1 s"));
  EXPECT_DOUBLE_EQ(scene_.next_change_s(), 101);
  Update(103.6);
  EXPECT_THAT(TextsOf(frames), Contains("base, 3 s"));
  EXPECT_DOUBLE_EQ(scene_.next_change_s(), 104);
  EXPECT_THAT(frames.Status(), Contains(EndsWith(", 3 s ago")));
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
  Move("base", 1'000'000'000);
  Update(100);
  EXPECT_THAT(frames.Status(), Contains("base: below map, under 1 s ago"));
  Move("base", 2'000'000'000);
  Update(101);
  EXPECT_THAT(frames.Status(), Contains("base: below map, 1.00 Hz, under 1 s ago"));
}

TEST_F(PoseDisplaysTest, FramesUpdatedWhileLookingBackAreNotSilent) {
  Display& frames = Add("Frames");
  for (int second = 1; second <= 2; ++second) Move("base", second * 1'000'000'000LL);
  Update(100);
  scene_.LookBack(100, 0.5);
  for (int second = 3; second <= 62; ++second) Move("base", second * 1'000'000'000LL);
  scene_.LookBack(100, 0);
  Update(160);
  EXPECT_THAT(TextsOf(frames), UnorderedElementsAre("map", "base"));
  EXPECT_THAT(frames.Status(), Contains("base: below map, 1.00 Hz"));
  EXPECT_DOUBLE_EQ(scene_.next_change_s(), 165) << "transforms of a pause count from its end";
}

TEST_F(PoseDisplaysTest, ShowsPastFrameAgesWhilePaused) {
  Display& frames = Add("Frames");
  Move("base", 1);
  Update(100);
  Update(103);
  (void)Draw();
  Move("other", 2);
  SetStandingStill(frames, "ages", "on");
  EXPECT_TRUE(scene_.pending());
  EXPECT_THAT(TextsOf(frames), UnorderedElementsAre("map", "base, 3 s")) << "no new message is taken in";
  EXPECT_THAT(frames.Status(), Contains(EndsWith(", 3 s ago")));
  SetStandingStill(frames, "silent after", "2");
  EXPECT_EQ(frames.Labels().back().color, MakeRgba(255, 178, 90));
  SetStandingStill(frames, "ages", "off");
  EXPECT_THAT(TextsOf(frames), UnorderedElementsAre("map", "base (silent)"));
  SetStandingStill(frames, "silent after", "4");
  EXPECT_THAT(TextsOf(frames), UnorderedElementsAre("map", "base"));
}

TEST_F(PoseDisplaysTest, PickingAFrameReturnsItsName) {
  Display& frames = Add("Frames", "", {"ages", "on"});
  Move("base", 1, {3, 1, 0});
  Update(100);
  EXPECT_EQ(frames.ValueAt({3, 1, 0}, 0), "base");
  SetStandingStill(frames, "ages", "off");
  Update(200);
  EXPECT_THAT(TextsOf(frames), Contains("base (silent)"));
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
  EXPECT_THAT(frames.Status(), Contains("501 frames"));
  EXPECT_THAT(frames.Status(), Contains("and 450 more"));
  EXPECT_FALSE(frames.HasFault());
  const Pixels low = Draw();
  set(2, 2);
  Update();
  EXPECT_GT(DifferentShare(low, Draw()), 0.02);
}

TEST_F(PoseDisplaysTest, OmitsAndReportsPosesThatAreNotNumbers) {
  foxglove::PosesInFrame poses = Wave(5);
  poses.mutable_poses(2)->mutable_position()->set_x(std::nan(""));
  Display& display = Show("Trajectory", "way", poses);
  (void)Draw();
  EXPECT_THAT(display.Status(), Contains(HasSubstr("1 pose is not made of numbers")));
}

}  // namespace
}  // namespace hgros::viewer::test
