#include "viewer/panels/dock/panel_below.hpp"

#include <imgui.h>
#include <imgui_internal.h>

#include <algorithm>

namespace hgros::viewer {

bool PanelBelow(float x, float y) {
  const ImGuiContext& context = *ImGui::GetCurrentContext();
  return std::any_of(context.Windows.begin(), context.Windows.end(), [&](const ImGuiWindow* window) {
    const bool takes_mouse = window->Active && !window->Hidden && (window->Flags & ImGuiWindowFlags_NoMouseInputs) == 0;
    return takes_mouse && window->OuterRectClipped.Contains({x, y});
  });
}

}  // namespace hgros::viewer
