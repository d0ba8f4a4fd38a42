#include "viewer/panels/overlay/pick_layer.hpp"

#include <imgui.h>

#include <cmath>
#include <optional>
#include <string>

namespace hgros::viewer {
namespace {

constexpr ImU32 kMark = IM_COL32(255, 225, 90, 255);
constexpr ImU32 kShade = IM_COL32(0, 0, 0, 200);

/// The place of a point on the screen, in ImGui's coordinates.
std::optional<ImVec2> PlaceOf(const Eigen::Vector3d& at, const Camera& camera, const Viewport& viewport, float scale) {
  const auto pixel = camera.PixelOf(at, viewport);
  if (!pixel || std::abs(pixel->x()) > 1e5 || std::abs(pixel->y()) > 1e5) return std::nullopt;
  return ImVec2(static_cast<float>(pixel->x()) / scale, static_cast<float>(pixel->y()) / scale);
}

void Write(ImDrawList& list, const ImVec2& at, const std::string& text) {
  list.AddText({at.x + 1, at.y + 1}, kShade, text.c_str());
  list.AddText(at, kMark, text.c_str());
}

void DrawMarks(const PointPicks& picks, const Camera& camera, const Viewport& viewport, float scale) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const float font = ImGui::GetFontSize();
  std::optional<ImVec2> before;
  for (std::size_t i = 0; i < picks.points().size(); ++i) {
    const auto place = PlaceOf(picks.points()[i].at, camera, viewport, scale);
    if (place && before) {
      list.AddLine(*before, *place, kShade, 3.5F);
      list.AddLine(*before, *place, kMark, 1.5F);
      if (const auto measured = picks.measurement()) {
        Write(list, {0.5F * (before->x + place->x) + 0.5F * font, 0.5F * (before->y + place->y) - font},
              MetersText(measured->distance));
      }
    }
    if (place) {
      const float arm = 0.5F * font;
      list.AddLine({place->x - arm, place->y}, {place->x + arm, place->y}, kMark, 1.5F);
      list.AddLine({place->x, place->y - arm}, {place->x, place->y + arm}, kMark, 1.5F);
      Write(list, {place->x + 0.4F * font, place->y + 0.2F * font}, std::to_string(i + 1));
    }
    before = place;
  }
}

void DrawPoint(std::size_t number, const PickedPoint& point) {
  ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(kMark), "%zu", number);
  ImGui::SameLine();
  ImGui::TextUnformatted(MetersText(point.at).c_str());
  ImGui::Indent();
  ImGui::TextUnformatted(point.display.empty() ? "display unknown" : point.display.c_str());
  if (!point.value.empty()) {
    ImGui::SameLine();
    ImGui::TextUnformatted(point.value.c_str());
  }
  if (point.in_frame) ImGui::TextDisabled("%s in %s", MetersText(*point.in_frame).c_str(), point.frame.c_str());
  ImGui::Unindent();
}

}  // namespace

void DrawPicks(PointPicks& picks, const Camera& camera, const Viewport& viewport, float pixels_per_unit) {
  if (picks.points().empty()) return;
  DrawMarks(picks, camera, viewport, pixels_per_unit);
  const float unit = ImGui::GetFontSize();
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({size.x - 0.6F * unit, 3.2F * unit}, ImGuiCond_FirstUseEver, {1, 0});
  bool stays = true;
  if (ImGui::Begin(
          "Picked points", &stays,
          ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoFocusOnAppearing)) {
    for (std::size_t i = 0; i < picks.points().size(); ++i) DrawPoint(i + 1, picks.points()[i]);
    if (const auto measured = picks.measurement()) {
      ImGui::Separator();
      ImGui::Text("distance %s", MetersText(measured->distance).c_str());
      ImGui::TextDisabled("in the plane %s, height %s", MetersText(measured->in_plane).c_str(),
                          MetersText(measured->step.z()).c_str());
      ImGui::TextDisabled("dx, dy, dz %s", MetersText(measured->step).c_str());
    } else {
      ImGui::TextDisabled("Pick a second point to measure the distance.");
    }
  }
  ImGui::End();
  if (!stays) picks.Clear();
}

}  // namespace hgros::viewer
