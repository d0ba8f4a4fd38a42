#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "hgros/session/session.hpp"
#include "viewer/app/surface/offscreen.hpp"
#include "viewer/scene/scene.hpp"

namespace hgros::viewer::test {

inline constexpr Viewport kPictureSize{320, 240};

/// A picture for comparison: 3 bytes per pixel, rows from the top.
using Pixels = std::vector<std::uint8_t>;

/// Share of the pixels that clearly have another color.
[[nodiscard]] double DifferentShare(const Pixels& a, const Pixels& b);

/// All tests draw into memory.
class DrawingTest : public ::testing::Test {
 protected:
  void SetUp() override;
};

/// A scene in memory with its own session. Messages published before Update have arrived when it returns.
class SceneTest : public DrawingTest {
 protected:
  /// Adds a display for `channel`, with settings as name, text, name, text ...
  Display& Add(const std::string& type, const std::string& channel = {}, const std::vector<std::string>& settings = {});
  void Update(double now_s = 0);
  static void Set(Display& display, const std::string& name, const std::string& text);
  /// The value of a setting.
  [[nodiscard]] static std::string SettingText(Display& display, const std::string& name);
  /// Changes a setting as a user does during a pause: no messages are taken in.
  void SetStandingStill(Display& display, const std::string& name, const std::string& text);
  /// Draws until the picture is complete.
  [[nodiscard]] Pixels Draw();
  /// Compares the picture with the golden one, which a person has checked. HGROS_KEEP_PICTURES=1 replaces that.
  void ExpectAsKept(const std::string& name);
  /// The same for a picture that was drawn before.
  void ExpectDrawnAsKept(const std::string& name);

  template <class T>
  void Publish(const std::string& channel, const T& message) {
    ASSERT_EQ(session_.ToAny(channel, message), PublishStatus::kOk);
  }
  /// Publishes a message and takes it in.
  template <class T>
  void Send(const std::string& channel, const T& message, double now_s = 0) {
    Publish(channel, message);
    Update(now_s);
  }
  /// Adds a display of a message.
  template <class T>
  Display& Show(const std::string& type, const std::string& channel, const T& message,
                const std::vector<std::string>& settings = {}) {
    Display& display = Add(type, channel, settings);
    Send(channel, message);
    return display;
  }
  void SetStatic(const std::string& parent, const std::string& child, const RigidTransform& T_parent_child = {}) {
    tree_.SetStatic(parent, child, T_parent_child);
    transforms_changed_ = true;
  }
  /// Changes where a frame is in "map".
  void Move(const std::string& frame, std::int64_t stamp_ns, const Eigen::Vector3d& at = Eigen::Vector3d::Zero()) {
    tree_.Set("map", frame, Time{stamp_ns}, RigidTransform({1, 0, 0, 0}, at));
    transforms_changed_ = true;
  }

  // What displays of several types do.

  /// When `old` is replaced, nothing of it is left in the picture: neither at once nor after a rest.
  template <class T>
  void ExpectNothingLeftOf(const T& old, const T& latest, double tolerance, const std::string& type,
                           const std::vector<std::string>& settings = {}) {
    Add(type, "channel", settings);
    Send("channel", old, 0);
    (void)Draw();
    Send("channel", latest, 1);
    const Pixels rewritten = Draw();
    Update(10);
    const Pixels settled = Draw();
    scene_.Remove(0);
    Add(type, "channel", settings);
    Send("channel", latest, 11);
    const Pixels fresh = Draw();
    EXPECT_LT(DifferentShare(rewritten, fresh), tolerance);
    EXPECT_LT(DifferentShare(settled, fresh), tolerance);
  }
  template <class T>
  void ExpectItMovesWithItsFrame(T message, double moved_share, const std::string& type) {
    message.set_frame_id("odom");
    Move("odom", 1);
    Show(type, "channel", message);
    const Pixels before = Draw();
    Move("odom", 2, {0, 3, 0});
    Update(1);
    EXPECT_GT(DifferentShare(before, Draw()), moved_share);
    Move("odom", 3);
    Update(2);
    EXPECT_LT(DifferentShare(before, Draw()), 0.002);
  }
  /// In a frame millions of meters away, with the camera there.
  template <class T>
  void ExpectTheSameFarAway(const T& in_map, const T& in_utm, const RigidTransform& T_map_utm, const std::string& type,
                            const std::vector<std::string>& settings = {}) {
    Show(type, "channel", in_map, settings);
    const Pixels here = Draw();
    SetStatic("map", "utm", T_map_utm);
    Send("channel", in_utm, 1);
    camera_.Follow(RigidTransform(), T_map_utm, true);
    EXPECT_LT(DifferentShare(here, Draw()), 0.01);
  }
  template <class T>
  void ExpectItWaitsAgainAfterAnEmptyMessage(T full, T empty, const std::string& type) {
    Display& display = Add(type, "channel");
    tree_.SetStatic("map", "other", RigidTransform());
    full.set_frame_id("lidar");
    empty.set_frame_id("lidar");
    Send("channel", full, 0);
    Update(2);
    EXPECT_TRUE(display.HasFault());
    Send("channel", empty, 3);
    EXPECT_FALSE(display.HasFault()) << display.Status().front();
    EXPECT_EQ(display.WaitsFor(), "");
    Send("channel", full, 10);
    EXPECT_FALSE(display.HasFault()) << "the transform may still come";
    EXPECT_NE(display.WaitsFor().find("lidar"), std::string::npos);
    Update(12);
    EXPECT_TRUE(display.HasFault());
  }
  /// A setting that is changed during a pause has its effect on the shown message, not on one that has arrived since.
  template <class T>
  void ExpectEffectWhilePaused(const T& shown, const T& arrived, const std::string& type, const std::string& setting,
                               const std::string& text) {
    Display& display = Show(type, "paused", shown);
    const Pixels before = Draw();
    Publish("paused", arrived);
    SetStandingStill(display, setting, text);
    const Pixels standing = Draw();
    scene_.Remove(0);
    Show(type, "fresh", shown, {setting, text});
    EXPECT_EQ(DifferentShare(standing, Draw()), 0) << setting;
    EXPECT_GT(DifferentShare(standing, before), 0.01) << setting;
    scene_.Remove(0);
  }

  Session session_;
  TransformTree tree_;
  FixedFrame frame_{tree_};
  Scene scene_;
  Camera camera_;
  bool transforms_changed_ = true;
};

}  // namespace hgros::viewer::test
