#pragma once

namespace hgros::viewer {

/// Sets ImGui's colors, sizes and font. `scale` is the number of screen pixels per pixel of the design.
void SetLook(float scale);

/// The color of errors and warnings.
struct WarningColor {
  static constexpr float kRgba[4] = {1.0F, 0.70F, 0.35F, 1.0F};
};

}  // namespace hgros::viewer
