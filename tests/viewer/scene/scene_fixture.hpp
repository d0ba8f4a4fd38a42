#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "hgros/session/session.hpp"
#include "viewer/app/offscreen.hpp"
#include "viewer/scene/scene.hpp"

namespace hgros::viewer::test {

inline constexpr Viewport kPictureSize{320, 240};

/// A picture as compared: 3 bytes a pixel, rows from the top.
using Pixels = std::vector<std::uint8_t>;

/// Share of the pixels that are clearly another colour.
[[nodiscard]] double DifferentShare(const Pixels& a, const Pixels& b);

/// What is drawn is drawn into memory.
class DrawingTest : public ::testing::Test {
 protected:
  void SetUp() override;
};

/// A scene in memory with a session of its own; what is published there has arrived when Update returns.
class SceneTest : public DrawingTest {
 protected:
  /// The display shows `channel`, with settings as name, text, name, text ...
  Display& Add(const std::string& type, const std::string& channel = {}, const std::vector<std::string>& settings = {});
  void Update(double now_s = 0);
  /// As a person does while the view stands still: nothing is taken in.
  void SetStandingStill(Display& display, const std::string& name, const std::string& text);
  /// Draws until the picture is whole.
  [[nodiscard]] Pixels Draw();
  /// The picture is as the one that was looked at and kept; HGROS_KEEP_PICTURES=1 keeps it.
  void ExpectAsKept(const std::string& name);
  /// Likewise of what was drawn before.
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
