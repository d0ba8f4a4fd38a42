#pragma once

#include <gtest/gtest.h>

#include <chrono>
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

  Session session_;
  TransformTree tree_;
  FixedFrame frame_{tree_};
  Scene scene_;
  Camera camera_;
  bool transforms_changed_ = true;
};

}  // namespace hgros::viewer::test
