#include "viewer/panels/overlay/color_legends.hpp"

#include <imgui.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "viewer/panels/dock/free_room.hpp"

namespace hgros::viewer {
namespace {

// In heights of the font.
constexpr float kBarWidth = 14;
constexpr float kLeastWidth = 6;  // Of a bar between panels: there is room for its limits.
constexpr float kBarHeight = 0.6F;
constexpr float kMargin = 0.8F;

void WriteShaded(ImDrawList& list, const ImVec2& at, const std::string& text) {
  list.AddText({at.x + 1, at.y + 1}, IM_COL32(0, 0, 0, 200), text.c_str());
  list.AddText(at, ImGui::GetColorU32(ImGuiCol_Text), text.c_str());
}

std::string LimitText(double limit) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", limit);
  return text;
}

void DrawBar(ImDrawList& list, const ImVec2& at, const ImVec2& size, ColorMap map) {
  static const std::vector<std::uint8_t> table = ColorMapTable();
  const std::uint8_t* color = table.data() + static_cast<std::size_t>(map) * kColorMapSteps * 3;
  const float step = size.x / static_cast<float>(kColorMapSteps);
  for (std::size_t i = 0; i < kColorMapSteps; ++i, color += 3) {
    const float x = at.x + static_cast<float>(i) * step;
    list.AddRectFilled({x, at.y}, {x + step, at.y + size.y}, IM_COL32(color[0], color[1], color[2], 255));
  }
}

}  // namespace

void DrawColorLegends(const Scene& scene) {
  std::vector<std::pair<std::string, ColorLegend>> legends;
  for (const Scene::Entry& entry : scene.entries()) {
    const auto legend = entry.visible ? entry.display->Legend() : std::nullopt;
    if (legend) legends.emplace_back(entry.name + ": " + legend->name, *legend);
  }
  if (legends.empty()) return;
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const PanelPlace room = FreeRoom();
  const float unit = ImGui::GetFontSize();
  const float left = room.x + kMargin * unit;
  const float width = std::min(kBarWidth * unit, room.width - 2 * kMargin * unit);
  float top = room.y + room.height - kMargin * unit;
  for (const auto& [name, legend] : legends) {
    top -= (2.5F + kBarHeight) * unit;
    if (top < room.y || width < kLeastWidth * unit) return;
    WriteShaded(list, {left, top}, name);
    DrawBar(list, {left, top + unit}, {width, kBarHeight * unit}, legend.map);
    const std::string highest = LimitText(legend.highest);
    const float limits = top + (1 + kBarHeight) * unit;
    WriteShaded(list, {left, limits}, LimitText(legend.lowest));
    WriteShaded(list, {left + width - ImGui::CalcTextSize(highest.c_str()).x, limits}, highest);
  }
}

}  // namespace hgros::viewer
