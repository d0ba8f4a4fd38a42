#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <string>

#include "foxglove/LaserScan.pb.h"
#include "viewer/e2e/message_parts.hpp"
#include "viewer/scene/scene_fixture.hpp"

namespace hgros::viewer::test {
namespace {

using foxglove::PackedElementField;
using foxglove::PointCloud;

/// A spiral staircase around `center`: its intensity grows with the turns, its color with the height. Doubles, so that
/// it may be anywhere.
PointCloud Spiral(const Eigen::Vector3d& center = Eigen::Vector3d::Zero(), int first = 0, int count = 4000) {
  PointCloud cloud;
  cloud.set_frame_id("map");
  for (const char* name : {"x", "y", "z"}) AddPointField(cloud, name, PackedElementField::FLOAT64, 8);
  AddPointField(cloud, "intensity", PackedElementField::FLOAT32, 4);
  AddPointField(cloud, "rgb", PackedElementField::UINT32, 4);
  for (int i = first; i < first + count; ++i) {
    const double turn = 6 * std::numbers::pi * i / 4000;
    const double radius = 2 + 3 * (i % 40) / 40.0;
    const double at[3] = {center.x() + radius * std::cos(turn), center.y() + radius * std::sin(turn),
                          center.z() + 6.0 * i / 4000 - 2};
    const auto intensity = static_cast<float>(i % 40);
    const std::uint32_t rgb = static_cast<std::uint32_t>(255 * i / 4000) << 16U | 0x40U;
    cloud.mutable_data()->append(reinterpret_cast<const char*>(at), sizeof at);
    cloud.mutable_data()->append(reinterpret_cast<const char*>(&intensity), sizeof intensity);
    cloud.mutable_data()->append(reinterpret_cast<const char*>(&rgb), sizeof rgb);
  }
  return cloud;
}

class PointsDisplayTest : public SceneTest {
 protected:
  /// Shows a cloud in a frame without a transform to the fixed one.
  Display& AddWithoutTransform() {
    tree_.SetStatic("map", "other", RigidTransform());
    PointCloud cloud = Spiral();
    cloud.set_frame_id("lidar");
    return Show("Point cloud", "cloud", cloud);
  }
};

TEST_F(PointsDisplayTest, ColorsByHeight) {
  Add("Ground");
  Show("Point cloud", "cloud", Spiral(), {"color", "axis", "size", "3"});
  ExpectAsKept("points_by_height");
}

TEST_F(PointsDisplayTest, ColorsByValueByTheirOwnColorsOrAllAlikeInMeters) {
  const std::pair<const char*, std::vector<std::string>> cases[] = {
      {"points_by_value", {"color", "value", "map", "fire", "size", "3"}},
      {"points_in_their_own_colors", {"color", "rgb", "size", "3"}},
      {"points_in_meters", {"color", "flat", "flat", "#40c0ff", "size", "0.25", "unit", "m"}}};
  for (const auto& [name, settings] : cases) {
    Show("Point cloud", "cloud", Spiral(), settings);
    ExpectAsKept(name);
    scene_.Remove(0);
  }
}

TEST_F(PointsDisplayTest, PointsKeptForeverLookLikeTheLatest) {
  for (const char* color : {"axis", "value", "rgb"}) {
    SCOPED_TRACE(color);
    Show("Point cloud", "cloud", Spiral(), {"color", color, "size", "3"});
    const Pixels latest = Draw();
    scene_.Remove(0);
    Show("Point cloud", "cloud", Spiral(), {"keep", "all", "color", color, "size", "3"});
    EXPECT_LT(DifferentShare(latest, Draw()), 0.01);
    scene_.Remove(0);
  }
}

TEST_F(PointsDisplayTest, AppendedPointsLookLikeAFullRedraw) {
  Display& display = Add("Point cloud", "cloud", {"keep", "all", "color", "flat", "size", "3"});
  for (int part = 0; part < 8; ++part) {
    Send("cloud", Spiral(Eigen::Vector3d::Zero(), part * 500, 500));
    (void)Draw();
  }
  EXPECT_EQ(display.points(), 4000U);
  const Pixels grown = Draw();
  scene_.Redraw();
  EXPECT_EQ(DifferentShare(grown, Draw()), 0);
}

TEST_F(PointsDisplayTest, AllSlicesTogetherAreTheWholePicture) {
  Add("Point cloud", "cloud", {"keep", "all", "color", "axis"});
  constexpr int kMessages = 120;  // 480 000 points: more than one slice
  for (int i = 0; i < kMessages; ++i) {
    Send("cloud", Spiral(Eigen::Vector3d(0.01 * i, 0.02 * i, 0)));
    scene_.Draw(camera_.Matrices(kPictureSize), 1);
  }
  const Pixels grown = Draw();
  camera_.Orbit(0.1, 0);
  (void)Draw();
  camera_.Orbit(-0.1, 0);
  EXPECT_LT(DifferentShare(grown, Draw()), 0.01);
}

TEST_F(PointsDisplayTest, LooksTheSameMillionsOfMetersAway) {
  for (const char* keep : {"latest", "all"}) {
    SCOPED_TRACE(keep);
    Show("Point cloud", "cloud", Spiral(), {"keep", keep, "color", "flat", "size", "3"});
    camera_.Reset();
    const Pixels here = Draw();
    scene_.Remove(0);
    const Eigen::Vector3d there(500'000, 5'400'000, 256);
    Show("Point cloud", "cloud", Spiral(there), {"keep", keep, "color", "flat", "size", "3"});
    camera_.Follow(RigidTransform(), RigidTransform({1, 0, 0, 0}, there), false);
    EXPECT_LT(DifferentShare(here, Draw()), 0.02);
    scene_.Remove(0);
  }
}

TEST_F(PointsDisplayTest, KeepsTheLastMessagesOrSeconds) {
  Display& count = Add("Point cloud", "cloud", {"keep", "count", "count", "2"});
  Display& time = Add("Point cloud", "cloud", {"keep", "time", "seconds", "1"});
  for (int i = 0; i < 3; ++i) Send("cloud", Spiral(Eigen::Vector3d::Zero(), 0, 100), 0.5 * i);
  EXPECT_EQ(count.points(), 200U);
  EXPECT_EQ(time.points(), 300U);
  EXPECT_EQ(time.next_change_s(), 1.0);
  Update(1.25);
  EXPECT_EQ(time.points(), 200U);
  EXPECT_EQ(count.points(), 200U);
}

TEST_F(PointsDisplayTest, OneAbsurdPointOrValueChangesNothingElse) {
  const PointCloud usual = Spiral(Eigen::Vector3d::Zero(), 0, 3000);
  PointCloud absurd = usual;
  const double far = 20'000;
  const float bright = 4e9F;
  const std::size_t stride = usual.point_stride();
  absurd.mutable_data()->replace(0, sizeof far, reinterpret_cast<const char*>(&far), sizeof far);     // NOLINT: bytes
  absurd.mutable_data()->replace(stride + 24, sizeof bright, reinterpret_cast<const char*>(&bright),  // NOLINT: bytes
                                 sizeof bright);
  for (const char* keep : {"latest", "all"}) {
    SCOPED_TRACE(keep);
    Show("Point cloud", "usual", usual, {"keep", keep, "color", "value", "size", "3"});
    const Pixels expected = Draw();
    scene_.Remove(0);
    const Display& display = Show("Point cloud", "absurd", absurd, {"keep", keep, "color", "value", "size", "3"});
    EXPECT_LT(DifferentShare(expected, Draw()), 0.005);
    EXPECT_LT(display.Bounds().sizes().maxCoeff(), 20);
    scene_.Remove(0);
  }
}

/// A spiral whose intensities are a hundred times too large.
PointCloud Absurd() {
  PointCloud absurd = Spiral();
  for (std::size_t at = 24; at < absurd.data().size(); at += absurd.point_stride()) {
    float value = 0;
    std::memcpy(&value, absurd.data().data() + at, sizeof value);
    value *= 100;
    std::memcpy(absurd.mutable_data()->data() + at, &value, sizeof value);
  }
  return absurd;
}

TEST_F(PointsDisplayTest, ColorsReturnAfterAMessageWithAbsurdValues) {
  for (const char* keep : {"latest", "all"}) {
    SCOPED_TRACE(keep);
    Show("Point cloud", "usual", Spiral(), {"keep", keep, "color", "value", "size", "3"});
    for (int i = 0; i < 20; ++i) Send("usual", Spiral());
    const Pixels expected = Draw();
    scene_.Remove(0);
    Show("Point cloud", "glitch", Spiral(), {"keep", keep, "color", "value", "size", "3"});
    for (int i = 0; i < 20; ++i) Send("glitch", i == 4 ? Absurd() : Spiral());
    Send("glitch", Spiral());
    EXPECT_LT(DifferentShare(expected, Draw()), 0.01);
    scene_.Remove(0);
  }
}

TEST_F(PointsDisplayTest, KeptValuesAreExactAfterAMessageWithAbsurdValues) {
  const Display& display = Show("Point cloud", "cloud", Absurd(), {"keep", "all"});
  Send("cloud", Spiral({0, 0, 20}));
  const double turn = 6 * std::numbers::pi * 20 / 4000;
  const std::string value = display.ValueAt({3.5 * std::cos(turn), 3.5 * std::sin(turn), 18.03}, 0.02);
  ASSERT_TRUE(value.starts_with("intensity = ")) << value;
  EXPECT_NEAR(std::stod(value.substr(12)), 20, 0.2);
}

TEST_F(PointsDisplayTest, KeepsFewBytesForAPointAlsoIfTheFirstMessageHasOne) {
  const Display& display = Show("Point cloud", "cloud", Spiral(Eigen::Vector3d::Zero(), 0, 1), {"keep", "all"});
  for (int i = 0; i < 250; ++i) Send("cloud", Spiral(Eigen::Vector3d(0.4 * i, 0.2 * i, 0)));
  EXPECT_EQ(display.points(), 1'000'001U);
  EXPECT_LT(display.gpu_bytes(), 9U * 1'000'000) << "7 for a point with value and color, and pages that are not full";
}

TEST_F(PointsDisplayTest, IsPlacedAgainWhenTheFixedFrameGetsANewRoot) {
  PointCloud cloud = Spiral();
  cloud.set_frame_id("odom");
  for (const char* keep : {"latest", "all"}) {
    SCOPED_TRACE(keep);
    SetStatic("odom", keep);
    Display& display = Show("Point cloud", keep, cloud, {"keep", keep, "color", "flat", "size", "3"});
    EXPECT_EQ(display.points(), 4000U);
  }
  ASSERT_EQ(frame_.name(), "odom");
  const Pixels before = Draw();
  SetStatic("map", "odom", RigidTransform({1, 0, 0, 0}, {0, 3, 0}));
  Update(1);
  ASSERT_EQ(frame_.name(), "map");
  for (const Scene::Entry& entry : scene_.entries()) {
    EXPECT_EQ(entry.display->points(), 4000U);
    EXPECT_FALSE(entry.display->HasFault());
    EXPECT_NEAR(entry.display->Bounds().center().y(), 3, 0.2);
    EXPECT_NE(entry.display->ValueAt({2, 3, -2}, 0.1), "") << "the first point";
  }
  EXPECT_GT(DifferentShare(before, Draw()), 0.01) << "they are 3 m aside";
  camera_.Follow(RigidTransform(), RigidTransform({1, 0, 0, 0}, {0, 3, 0}), false);
  EXPECT_LT(DifferentShare(before, Draw()), 0.02);
}

TEST_F(PointsDisplayTest, ColorsShowHeightsOfOlderKeptPointsAlsoAfterANewRoot) {
  tree_.SetStatic("odom", "lidar", RigidTransform());
  PointCloud high = Spiral({0, 0, 100});
  high.set_frame_id("odom");
  const Display& display = Show("Point cloud", "cloud", high, {"keep", "all", "color", "axis"});
  for (int i = 0; i < 4; ++i) Send("cloud", high);
  SetStatic("map", "odom");
  Update(1);
  ASSERT_EQ(frame_.name(), "map");
  for (int i = 0; i < 20; ++i) Send("cloud", Spiral());
  EXPECT_GT(display.Legend().value().highest, 103);
}

TEST_F(PointsDisplayTest, ReportsKeptPointsThatHaveNoPlaceInTheNewFixedFrame) {
  PointCloud cloud = Spiral();
  Display& display = Show("Point cloud", "cloud", cloud, {"keep", "all"});
  tree_.SetStatic("world", "lidar", RigidTransform());
  frame_.Ask("world");
  scene_.Update({frame_, 1, true, true});
  EXPECT_TRUE(display.HasFault());
  EXPECT_THAT(display.Status().front(), ::testing::HasSubstr("map"));
  EXPECT_TRUE(display.Bounds().isEmpty());
  cloud.set_frame_id("lidar");
  Send("cloud", cloud, 2);
  EXPECT_FALSE(display.Bounds().isEmpty());
  EXPECT_TRUE(display.HasFault()) << "older points are still hidden";
  SetStatic("world", "map");
  Update(3);
  EXPECT_FALSE(display.HasFault());
}

TEST_F(PointsDisplayTest, TheNewestMessageIsPlacedWhenItsTransformComesLate) {
  tree_.SetStatic("map", "other", RigidTransform());
  PointCloud cloud = Spiral();
  cloud.set_frame_id("lidar");
  cloud.mutable_timestamp()->set_seconds(1);
  Display& display = Show("Point cloud", "cloud", cloud);
  Update(2);
  EXPECT_TRUE(display.HasFault());
  EXPECT_EQ(display.points(), 0U);
  Move("lidar", 50'000'000'000);  // The stamp is too old for it: the latest one counts, as for a grid.
  Update(60);
  EXPECT_EQ(display.points(), 4000U);
  EXPECT_FALSE(display.HasFault());
  EXPECT_THAT(display.Status(), ::testing::Not(::testing::Contains(::testing::HasSubstr("no transform"))));
}

TEST_F(PointsDisplayTest, BoundsLeaveOutAMessageFarFromTheOthers) {
  for (const char* keep : {"all", "time"}) {
    SCOPED_TRACE(keep);
    for (const Eigen::Vector3d& there : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(500'000, 5'400'000, 256)}) {
      const Display& display = Add("Point cloud", "cloud", {"keep", keep});
      const Eigen::Vector3d far = there.x() > 0 ? Eigen::Vector3d::Zero() : Eigen::Vector3d(4e7, 0, 0);
      for (const Eigen::Vector3d& center : {there, far, there, there}) Send("cloud", Spiral(center, 0, 100));
      EXPECT_EQ(display.points(), 400U);
      const Eigen::AlignedBox3d bounds = display.Bounds();
      EXPECT_TRUE(bounds.contains(there + Eigen::Vector3d(3, 0.5, -1.9))) << bounds.min() << "\n" << bounds.max();
      EXPECT_LT(bounds.sizes().maxCoeff(), 20);
      scene_.Remove(0);
    }
  }
}

TEST_F(PointsDisplayTest, WaitsForTransformsBeforeItReportsThem) {
  Display& display = AddWithoutTransform();
  EXPECT_EQ(display.points(), 0U);
  EXPECT_FALSE(display.HasFault()) << "it may still come";
  EXPECT_THAT(display.WaitsFor(), ::testing::HasSubstr("lidar"));
  SetStatic("map", "lidar");
  Update(1);
  EXPECT_EQ(display.points(), 4000U);
  EXPECT_FALSE(display.HasFault());
  EXPECT_EQ(display.WaitsFor(), "");
}

TEST_F(PointsDisplayTest, IsNeverFaultyWhenEachTransformComesShortlyAfterItsCloud) {
  Display& display = Add("Point cloud", "cloud");
  Move("lidar", 999'999'990);
  for (int i = 1; i <= 5; ++i) {
    PointCloud cloud = Spiral();
    cloud.set_frame_id("lidar");
    cloud.mutable_timestamp()->set_seconds(i);
    Send("cloud", cloud, i);
    EXPECT_FALSE(display.HasFault()) << "nanoseconds after the newest transform";
    Move("lidar", i * 1'000'000'000L + 999'999'990);
    Update(i + 0.01);
    EXPECT_EQ(display.points(), 4000U);
    EXPECT_FALSE(display.HasFault());
    EXPECT_EQ(display.WaitsFor(), "");
  }
}

TEST_F(PointsDisplayTest, StopsWaitingForATransformAfterAWhile) {
  Display& display = AddWithoutTransform();
  EXPECT_EQ(display.next_change_s(), 2.0);
  Update(2);
  EXPECT_EQ(display.next_change_s(), std::numeric_limits<double>::infinity());
  EXPECT_TRUE(display.HasFault());
  EXPECT_THAT(display.Status().front(), ::testing::HasSubstr("lidar"));
  EXPECT_TRUE(scene_.pending()) << "its row is another color now";
  EXPECT_THAT(display.Status(), ::testing::Contains("1 message had no transform."));
}

TEST_F(PointsDisplayTest, ReportsAMalformedCloud) {
  PointCloud cloud = Spiral();
  cloud.mutable_data()->pop_back();
  Display& display = Show("Point cloud", "cloud", cloud);
  EXPECT_TRUE(display.HasFault());
  EXPECT_EQ(display.points(), 0U);
  Send("cloud", Spiral());
  EXPECT_FALSE(display.HasFault());
  Send("cloud", PointCloud());
  EXPECT_EQ(display.points(), 0U);
  EXPECT_THAT(display.Status().front(), ::testing::HasSubstr("no points"));
}

TEST_F(PointsDisplayTest, DrawsAScan) {
  Add("Ground");
  Add("Laser scan", "scan", {"color", "value", "size", "4"});
  foxglove::LaserScan scan;
  scan.set_frame_id("laser");
  scan.set_start_angle(-0.75 * std::numbers::pi);
  scan.set_end_angle(0.75 * std::numbers::pi);
  for (int i = 0; i < 541; ++i) {
    const double angle = (1.5 * i / 540 - 0.75) * std::numbers::pi;
    scan.add_ranges(std::min(4 / std::abs(std::cos(angle)), 3 / std::abs(std::sin(angle))));
  }
  Send("scan", scan);
  camera_.LookFromAbove();
  ExpectAsKept("scan_of_a_room");
}

TEST_F(PointsDisplayTest, EachScanHasAColorOfItsOwn) {
  Display& front = Add("Laser scan", "front");
  Add("Ground");
  Display& rear = Add("Laser scan", "rear");
  EXPECT_EQ(SettingText(front, "color"), "flat");
  EXPECT_NE(SettingText(front, "flat"), SettingText(rear, "flat"));
  EXPECT_FALSE(front.Legend());
  const std::string color_of_rear = SettingText(rear, "flat");
  scene_.Remove(0);
  EXPECT_NE(SettingText(Add("Laser scan", "left"), "flat"), color_of_rear) << "also after another was removed";
}

TEST_F(PointsDisplayTest, CloudsWithColorsStartInTheirColorsUnlessToldOtherwise) {
  Display& cloud = Add("Point cloud", "cloud");
  EXPECT_EQ(SettingText(cloud, "color"), "axis");
  Send("cloud", Spiral());
  EXPECT_EQ(SettingText(cloud, "color"), "rgb");
  const std::pair<const char*, const char*> given[] = {{"color", "axis"},     {"axis", "x"},   {"map", "fire"},
                                                       {"auto range", "off"}, {"lowest", "0"}, {"highest", "3"}};
  for (const auto& [name, value] : given) {
    EXPECT_EQ(SettingText(Show("Point cloud", "told", Spiral(), {name, value}), "color"), "axis") << name;
  }
}

TEST_F(PointsDisplayTest, HasALegendWithTheLimitsOfItsColors) {
  Display& display = Add("Point cloud", "cloud", {"color", "value", "map", "fire"});
  EXPECT_FALSE(display.Legend()) << "there is no point yet";
  Send("cloud", Spiral());
  const ColorLegend legend = display.Legend().value();
  EXPECT_EQ(legend.name, "intensity");
  EXPECT_EQ(legend.map, ColorMap::kFire);
  EXPECT_EQ(legend.lowest, 0);
  EXPECT_EQ(legend.highest, 39);
  SetStandingStill(display, "color", "axis");
  EXPECT_EQ(display.Legend()->name, "z in m");
  SetStandingStill(display, "color", "rgb");
  EXPECT_FALSE(display.Legend());
}

TEST_F(PointsDisplayTest, ClearRemovesAllPoints) {
  Display& display = Add("Point cloud", "cloud", {"keep", "all"});
  Update();
  const Pixels empty = Draw();
  Send("cloud", Spiral());
  EXPECT_GT(DifferentShare(empty, Draw()), 0.005);
  display.Clear();
  scene_.Redraw();
  EXPECT_EQ(display.points(), 0U);
  EXPECT_EQ(DifferentShare(empty, Draw()), 0);
}

}  // namespace
}  // namespace hgros::viewer::test
