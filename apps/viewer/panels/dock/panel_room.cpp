#include "viewer/panels/dock/panel_room.hpp"

#include <imgui.h>

#include <algorithm>

namespace hgros::viewer {

PanelPlace PanelRoom() {
  const float unit = ImGui::GetFontSize();
  const ImVec2 screen = ImGui::GetIO().DisplaySize;
  const float margin = 0.6F * unit;
  const float right = std::max(kNarrowestPanel * unit, screen.x - margin);
  const float lower = std::max(kLowestPanel * unit, screen.y - ImGui::GetFrameHeight() - 3.2F * unit);
  // In a small window it covers the list of displays.
  const float left = std::min(22.2F * unit, right - kNarrowestPanel * unit);
  const float top = std::min(ImGui::GetFrameHeight() + unit, lower - kLowestPanel * unit);
  return {left, top, right - left, lower - top};
}

}  // namespace hgros::viewer
