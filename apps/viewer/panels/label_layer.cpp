#include "viewer/panels/label_layer.hpp"

#include <imgui.h>

namespace hgros::viewer {

void DrawLabels(std::span<const Label> labels, const Camera& camera, const Viewport& viewport, float pixels_per_unit) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const float lift = ImGui::GetFontSize() * 0.4F;
  for (const Label& label : labels) {
    const auto pixel = camera.PixelOf(label.at, viewport);
    if (!pixel || pixel->x() < 0 || pixel->y() < 0 || pixel->x() > viewport.width || pixel->y() > viewport.height) {
      continue;
    }
    const ImVec2 at(static_cast<float>(pixel->x()) / pixels_per_unit + lift,
                    static_cast<float>(pixel->y()) / pixels_per_unit - lift);
    list.AddText({at.x + 1, at.y + 1}, IM_COL32(0, 0, 0, 200), label.text.c_str());
    list.AddText(at, IM_COL32(235, 238, 242, 255), label.text.c_str());
  }
  if (!camera.anchor()) return;
  if (const auto pixel = camera.PixelOf(*camera.anchor(), viewport)) {
    const ImVec2 at(static_cast<float>(pixel->x()) / pixels_per_unit, static_cast<float>(pixel->y()) / pixels_per_unit);
    list.AddCircle(at, 0.45F * ImGui::GetFontSize(), IM_COL32(255, 180, 80, 255), 0, 1.5F);
    list.AddCircleFilled(at, 0.12F * ImGui::GetFontSize(), IM_COL32(255, 180, 80, 255));
  }
}

}  // namespace hgros::viewer
