#pragma once

namespace hgros::viewer {

/// Place and size of a window, in ImGui's coordinates.
struct PanelPlace {
  float x = 0;
  float y = 0;
  float width = 0;
  float height = 0;
  bool operator==(const PanelPlace&) const = default;
};

// The least size of a panel, in heights of the font.
inline constexpr float kNarrowestPanel = 12;
inline constexpr float kLowestPanel = 6;

}  // namespace hgros::viewer
