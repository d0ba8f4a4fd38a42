#pragma once

namespace hgros::viewer {

/// Gives ImGui its colours, sizes and font, for a screen on which one pixel of a plan is `scale` pixels wide.
void SetLook(float scale);

/// What is wrong stands in this colour.
struct WarningColor {
  static constexpr float kRgba[4] = {1.0F, 0.70F, 0.35F, 1.0F};
};

}  // namespace hgros::viewer
