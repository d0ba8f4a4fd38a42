#include "viewer/panels/dock/free_room.hpp"

#include <imgui.h>
#include <imgui_internal.h>

#include <algorithm>
#include <vector>

namespace hgros::viewer {
namespace {

/// The places along one axis where a free rectangle may begin or end.
std::vector<float> Edges(float begin, float end, std::span<const PanelPlace> taken, float PanelPlace::*corner,
                         float PanelPlace::*size) {
  std::vector<float> edges = {begin, end};
  for (const PanelPlace& place : taken) {
    for (const float edge : {place.*corner, place.*corner + place.*size}) edges.push_back(std::clamp(edge, begin, end));
  }
  std::ranges::sort(edges);
  return edges;
}

bool Overlaps(const PanelPlace& place, float left, float right, float top, float bottom) {
  return place.x < right && place.x + place.width > left && place.y < bottom && place.y + place.height > top;
}

}  // namespace

PanelPlace LargestFree(const PanelPlace& all, std::span<const PanelPlace> taken) {
  const std::vector<float> columns = Edges(all.x, all.x + all.width, taken, &PanelPlace::x, &PanelPlace::width);
  const std::vector<float> rows = Edges(all.y, all.y + all.height, taken, &PanelPlace::y, &PanelPlace::height);
  PanelPlace best;
  const auto is_better = [&](float width, float height) { return width * height > best.width * best.height; };
  // The largest candidates come first. What is not better even if nothing covers it is not tried.
  for (auto left = columns.begin(); left != columns.end() && is_better(columns.back() - *left, all.height); ++left) {
    for (auto right = columns.end(); is_better(*--right - *left, all.height);) {
      for (auto top = rows.begin(); is_better(*right - *left, rows.back() - *top); ++top) {
        for (auto bottom = rows.end(); is_better(*right - *left, *--bottom - *top);) {
          const bool covered = std::ranges::any_of(
              taken, [&](const PanelPlace& one) { return Overlaps(one, *left, *right, *top, *bottom); });
          if (!covered) best = {*left, *top, *right - *left, *bottom - *top};
        }
      }
    }
  }
  return best.width * best.height < 0.1F * all.width * all.height ? all : best;
}

PanelPlace FreeRoom() {
  const ImVec2 screen = ImGui::GetIO().DisplaySize;
  std::vector<PanelPlace> taken;
  for (const ImGuiWindow* const window : ImGui::GetCurrentContext()->Windows) {
    // ImGui begins its fallback window in each frame, and does not draw it.
    const bool shown = (window->Active || window->WasActive) && !window->Hidden && !window->IsFallbackWindow;
    if (!shown || (window->Flags & (ImGuiWindowFlags_ChildWindow | ImGuiWindowFlags_Tooltip)) != 0) continue;
    const ImRect place = window->Rect();
    taken.push_back({place.Min.x, place.Min.y, place.GetWidth(), place.GetHeight()});
  }
  return LargestFree({0, 0, screen.x, screen.y}, taken);
}

}  // namespace hgros::viewer
