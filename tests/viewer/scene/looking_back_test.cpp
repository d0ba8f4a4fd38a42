#include <chrono>
#include <limits>

#include "foxglove/PoseInFrame.pb.h"
#include "foxglove/PosesInFrame.pb.h"
#include "viewer/e2e/message_parts.hpp"
#include "viewer/scene/scene_fixture.hpp"

namespace hgros::viewer::test {
namespace {

foxglove::PointCloud PointOnX(double x) {
  foxglove::PointCloud cloud;
  cloud.set_frame_id("map");
  for (const char* name : {"x", "y", "z"}) AddPointField(cloud, name, foxglove::PackedElementField::FLOAT64, 8);
  const double at[] = {x, 0, 0};
  cloud.mutable_data()->assign(reinterpret_cast<const char*>(at), sizeof at);  // NOLINT: bytes are bytes
  return cloud;
}

foxglove::PoseInFrame PoseOnX(double x) {
  foxglove::PoseInFrame pose;
  pose.set_frame_id("map");
  SetPose(*pose.mutable_pose(), RigidTransform({1, 0, 0, 0}, {x, 0, 0}));
  return pose;
}

/// Number of pixels that are not background.
std::size_t Drawn(const Pixels& pixels) {
  std::size_t drawn = 0;
  for (std::size_t i = 0; i + 2 < pixels.size(); i += 3) drawn += pixels[i] > 60 || pixels[i + 1] > 60 ? 1 : 0;
  return drawn;
}

class LookingBackTest : public SceneTest {};

TEST_F(LookingBackTest, ShowsThePointsOfThatTime) {
  Add("Point cloud", "cloud", {"keep", "time", "seconds", "60", "color", "flat", "size", "4"});
  for (int second = 0; second < 5; ++second) Send("cloud", PointOnX(second - 2), second);
  EXPECT_EQ(scene_.oldest_s(), 0);
  const std::size_t all = Drawn(Draw());
  scene_.LookBack(4, 2.5);
  EXPECT_TRUE(scene_.pending());
  const std::size_t two = Drawn(Draw());
  scene_.LookBack(4, 2.4);
  (void)Draw();
  scene_.LookBack(4, 0);
  EXPECT_EQ(Drawn(Draw()), all);
  EXPECT_NEAR(static_cast<double>(two) / static_cast<double>(all), 2.0 / 5, 0.01);
}

TEST_F(LookingBackTest, CountsDroppedMessagesOfCurrentDisplays) {
  Add("Point cloud", "one");
  Add("Point cloud", "other");
  const auto flood = [&](const std::string& channel, int count) {
    for (int i = 0; i < count; ++i) {
      Publish(channel, PointOnX(0));
      ASSERT_TRUE(session_.WaitIdle(std::chrono::seconds(10))) << "no message is dropped on its way";
    }
  };
  constexpr int kMore = 40;  // more than can wait
  flood("one", kMore);
  ASSERT_GT(scene_.dropped(), 0U);
  scene_.CountDropped();
  EXPECT_EQ(scene_.dropped(), 0U);
  flood("one", 7);
  flood("other", kMore);
  const std::uint64_t both = scene_.dropped();
  scene_.Remove(0);
  EXPECT_EQ(scene_.dropped(), both - 7) << "only those of the other display";
  EXPECT_GT(scene_.dropped(), 0U);
}

TEST_F(LookingBackTest, ShowsThePosesOfThatTime) {
  Display& trail = Add("Pose", "pose", {"trail", "100", "style", "line"});
  for (int second = 0; second < 5; ++second) Send("pose", PoseOnX(2 * second - 4), second);
  EXPECT_EQ(trail.oldest_s(), 0);
  const std::size_t all = Drawn(Draw());
  scene_.LookBack(4, 2);
  const std::size_t half = Drawn(Draw());
  EXPECT_LT(half, all);
  EXPECT_GT(half, 0U);
  scene_.LookBack(4, 100);
  EXPECT_EQ(Drawn(Draw()), 0U);
  scene_.LookBack(4, 0);
  EXPECT_EQ(Drawn(Draw()), all);
}

TEST_F(LookingBackTest, ForgetsTimesOfRemovedPoses) {
  Display& trail = Add("Pose", "pose", {"trail", "3"});
  for (int second = 0; second < 10; ++second) {
    Send("pose", PoseOnX(second), second);
    EXPECT_EQ(trail.oldest_s(), std::max(0, second - 2));
  }
}

TEST_F(LookingBackTest, ContinuesWithNewMessages) {
  Add("Trajectory", "way", {"style", "line"});
  foxglove::PosesInFrame way;
  way.set_frame_id("map");
  for (int second = 0; second < 6; ++second) {
    way.add_poses()->mutable_position()->set_x(2 * second - 5);
    if (second == 5) scene_.LookBack(4, 3);
    Send("way", way, second);
    (void)Draw();
  }
  const Pixels grown = Draw();
  scene_.LookBack(5, 0);
  scene_.Redraw();
  EXPECT_LT(DifferentShare(grown, Draw()), 0.002) << "a message brings it back to the newest";
}

TEST_F(LookingBackTest, ShowsPastPlacesOfFrames) {
  Display& frames = Add("Frames");
  for (int second = 1; second <= 5; ++second) Move("base", second * 1'000'000'000LL, {1.0 * second, 0, 0});
  Update(5);
  const auto base = [&] {
    for (const Label& label : frames.Labels()) {
      if (label.text == "base") return label.at.x();
    }
    return -1.0;
  };
  EXPECT_EQ(base(), 5);
  EXPECT_EQ(frames.oldest_s(), 1);
  scene_.LookBack(5, 2.5);
  EXPECT_DOUBLE_EQ(base(), 2.5);
  scene_.LookBack(5, 0);
  EXPECT_EQ(base(), 5);
}

TEST_F(LookingBackTest, IsLimitedByTheHistoryOfVisibleFrames) {
  Add("Pose", "pose", {"trail", "100"});
  Add("Frames");
  for (int second = 0; second < 60; ++second) {
    Move("base", (second + 1) * 1'000'000'000LL, {1.0 * second, 0, 0});
    Send("pose", PoseOnX(second), second);
  }
  EXPECT_EQ(scene_.oldest_s(), 0);
  EXPECT_NEAR(scene_.truthful_since_s(), 59 - 10, 1);
  scene_.SetVisible(1, false);
  EXPECT_EQ(scene_.truthful_since_s(), -std::numeric_limits<double>::infinity()) << "the frames are hidden";
  scene_.SetVisible(0, false);
  EXPECT_EQ(scene_.oldest_s(), std::numeric_limits<double>::infinity()) << "the poses are hidden";
}

TEST_F(LookingBackTest, IsUnlimitedWhenNoFrameMoves) {
  Add("Frames");
  (void)tree_.SetStatic("map", "base", RigidTransform({1, 0, 0, 0}, {1, 0, 0}));
  Update(5);
  EXPECT_EQ(scene_.truthful_since_s(), -std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace hgros::viewer::test
