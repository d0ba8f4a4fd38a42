#include "viewer/panels/dock/panel_room.hpp"

#include <imgui.h>

#include <algorithm>

namespace hgros::viewer {

PanelPlace PanelRoom() {
  constexpr float kNarrowest = 12;  // heights of the font
  constexpr float kLowest = 6;
  const float unit = ImGui::GetFontSize();
  const ImVec2 screen = ImGui::GetIO().DisplaySize;
  const float margin = 0.6F * unit;
  const float right = std::max(kNarrowest * unit, screen.x - margin);
  const float lower = std::max(kLowest * unit, screen.y - ImGui::GetFrameHeight() - 3.2F * unit);
  // In a small window it covers the list of displays.
  const float left = std::min(22.2F * unit, right - kNarrowest * unit);
  const float top = std::min(ImGui::GetFrameHeight() + unit, lower - kLowest * unit);
  return {left, top, right - left, lower - top};
}

}  // namespace hgros::viewer
