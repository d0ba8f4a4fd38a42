#include "viewer/panels/overlay/awaited_layer.hpp"

#include <imgui.h>

#include <algorithm>

namespace hgros::viewer {
namespace {

constexpr float kWidestText = 48;  // heights of the font

}  // namespace

void DrawAwaited(const std::string& awaited, const std::string& reach, const PanelPlace& room) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const float unit = ImGui::GetFontSize();
  const float width = std::min(kWidestText * unit, room.width);
  float y = room.y + 0.12F * room.height;
  const auto write = [&](const std::string& text, ImU32 color) {
    const ImVec2 size = ImGui::CalcTextSize(text.c_str(), nullptr, false, width);
    const float x = room.x + 0.5F * (room.width - size.x);
    list.AddText(nullptr, unit, {x + 1, y + 1}, IM_COL32(0, 0, 0, 200), text.c_str(), nullptr, width);
    list.AddText(nullptr, unit, {x, y}, color, text.c_str(), nullptr, width);
    y += size.y + 0.6F * unit;
  };
  write(awaited, ImGui::GetColorU32(ImGuiCol_Text));
  write(reach, ImGui::GetColorU32(ImGuiCol_TextDisabled));
}

}  // namespace hgros::viewer
