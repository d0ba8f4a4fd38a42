#include "viewer/panels/overlay/label_layer.hpp"

#include <imgui.h>

#include <algorithm>
#include <string_view>

#include "viewer/data/cut_text.hpp"
#include "viewer/panels/overlay/name_piles.hpp"

namespace hgros::viewer {
namespace {

constexpr float kSmallestText = 3;
constexpr float kLargestText = 400;
constexpr std::size_t kMostLabels = 1000;      ///< Largest number of visible labels.
constexpr std::size_t kMostLetters = 100'000;  ///< Largest size of all labels together, in bytes.

/// In pixels.
float HeightOnScreen(const Label& label, const ViewMatrices& view) {
  float height = label.height;
  if (label.in_meters) {
    const Eigen::Vector3f from_eye = (label.at - view.eye).cast<float>();
    height *= view.pixels_per_meter_at_1m / (view.clip_from_eye * from_eye.homogeneous()).w();
  }
  return std::min(height, kLargestText);
}

/// With a shadow.
void Write(ImDrawList& list, float size, const ImVec2& at, Rgba color, std::string_view text) {
  const char* const end = text.data() + text.size();
  list.AddText(nullptr, size, {at.x + 1, at.y + 1}, MakeRgba(0, 0, 0, AlphaOf(color) * 4 / 5), text.data(), end);
  list.AddText(nullptr, size, at, color, text.data(), end);
}

}  // namespace

void DrawLabels(std::span<const Label> labels, const Camera& camera, const Viewport& viewport, float pixels_per_unit) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const float usual = ImGui::GetFontSize();
  const float lift = usual * 0.4F;
  const ViewMatrices view = camera.Matrices(viewport);
  std::size_t drawn = 0;
  std::size_t letters = kMostLetters;
  std::vector<PlacedName> names;
  for (const Label& label : labels) {
    const auto pixel = camera.PixelOf(label.at, viewport);
    if (!pixel || pixel->x() < 0 || pixel->y() < 0 || pixel->x() > viewport.width || pixel->y() > viewport.height) {
      continue;
    }
    const ImVec2 at(static_cast<float>(pixel->x()) / pixels_per_unit + lift,
                    static_cast<float>(pixel->y()) / pixels_per_unit - lift);
    const float size = label.height > 0 ? HeightOnScreen(label, view) / pixels_per_unit : usual;
    if (size < kSmallestText) continue;
    const std::string_view text = CutText(label.text);
    if (++drawn > kMostLabels || text.size() > letters) break;
    letters -= text.size();
    if (label.height > 0) {
      Write(list, size, at, label.color, text);
    } else {
      names.push_back({at.x, at.y, text, label.color});
    }
  }
  for (const NamePile& pile : PileNames(names, usual, Label().color)) {
    float y = pile.y;
    for (const NamePile::Entry& entry : pile.entries) {
      Write(list, usual, {pile.x, y}, entry.color, entry.text);
      y += usual * static_cast<float>(1 + std::ranges::count(entry.text, '\n'));
    }
  }
  if (!camera.anchor()) return;
  if (const auto pixel = camera.PixelOf(*camera.anchor(), viewport)) {
    const ImVec2 at(static_cast<float>(pixel->x()) / pixels_per_unit, static_cast<float>(pixel->y()) / pixels_per_unit);
    list.AddCircle(at, 0.45F * ImGui::GetFontSize(), IM_COL32(255, 180, 80, 255), 0, 1.5F);
    list.AddCircleFilled(at, 0.12F * ImGui::GetFontSize(), IM_COL32(255, 180, 80, 255));
  }
}

}  // namespace hgros::viewer
