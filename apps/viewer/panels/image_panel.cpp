#include "viewer/panels/image_panel.hpp"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include "viewer/data/image/image_value.hpp"

namespace hgros::viewer {
namespace {

constexpr float kMostZoom = 200;
constexpr float kWheelFactor = 1.2F;

}  // namespace

void ImagePanel::Draw(const Scene& scene) {
  const float unit = ImGui::GetFontSize();
  const ImVec2 screen = ImGui::GetIO().DisplaySize;
  float right = screen.x - 0.6F * unit;
  std::erase_if(parts_, [&](const auto& part) {
    return std::ranges::none_of(scene.entries(),
                                [&](const Scene::Entry& entry) { return entry.display.get() == part.first; });
  });
  for (const Scene::Entry& entry : scene.entries()) {
    if (!entry.visible) continue;
    const auto image = entry.display->Image();
    if (!image) continue;
    const float width = std::min(25 * unit, 0.45F * screen.x);
    const float height = width * static_cast<float>(image->picture->height) / static_cast<float>(image->picture->width);
    const ImVec2 size(width, std::clamp(height, 4 * unit, 0.5F * screen.y) + 4.5F * unit);
    ImGui::SetNextWindowPos({right, screen.y - 2.6F * unit}, ImGuiCond_FirstUseEver, {1, 1});
    ImGui::SetNextWindowSize(size, ImGuiCond_FirstUseEver);
    right = std::max(right - size.x - 0.6F * unit, size.x);
    const std::string title = entry.name + "##image " + entry.channel;
    if (ImGui::Begin(title.c_str(), nullptr,
                     ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoScrollbar |
                         ImGuiWindowFlags_NoScrollWithMouse | ImGuiWindowFlags_NoFocusOnAppearing)) {
      DrawImage(*image, parts_[entry.display.get()]);
    }
    ImGui::End();
  }
}

void ImagePanel::DrawImage(const ShownImage& image, Part& part) {
  const ImagePicture& picture = *image.picture;
  const auto width = static_cast<float>(picture.width);
  const auto height = static_cast<float>(picture.height);
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const ImVec2 room = ImGui::GetContentRegionAvail();
  const ImVec2 canvas(std::max(room.x, 8.0F), std::max(room.y - ImGui::GetTextLineHeightWithSpacing(), 8.0F));
  const ImVec2 middle(corner.x + 0.5F * canvas.x, corner.y + 0.5F * canvas.y);
  const float fit = std::min(canvas.x / width, canvas.y / height);
  const ImGuiIO& io = ImGui::GetIO();

  ImGui::InvisibleButton("image", canvas);
  const bool hovered = ImGui::IsItemHovered();
  if (hovered && ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left)) {
    part = {};
  } else if (ImGui::IsItemActive()) {
    part.middle_x -= io.MouseDelta.x / (fit * part.zoom * width);
    part.middle_y -= io.MouseDelta.y / (fit * part.zoom * height);
  }
  if (hovered && io.MouseWheel != 0) {  // Zooms around the pointer.
    const float before = fit * part.zoom;
    part.zoom = std::clamp(part.zoom * std::pow(kWheelFactor, io.MouseWheel), 1.0F, kMostZoom);
    const float shift = 1 / before - 1 / (fit * part.zoom);
    part.middle_x += (io.MousePos.x - middle.x) * shift / width;
    part.middle_y += (io.MousePos.y - middle.y) * shift / height;
  }
  const float half = 0.5F / part.zoom;
  part.middle_x = std::clamp(part.middle_x, half, 1 - half);
  part.middle_y = std::clamp(part.middle_y, half, 1 - half);

  const float scale = fit * part.zoom;
  const ImVec2 from(middle.x - part.middle_x * width * scale, middle.y - part.middle_y * height * scale);
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.PushClipRect(corner, {corner.x + canvas.x, corner.y + canvas.y}, true);
  list.AddImage(reinterpret_cast<ImTextureID>(static_cast<std::uintptr_t>(image.texture)), from,  // NOLINT: ImGui's way
                {from.x + width * scale, from.y + height * scale});
  list.PopClipRect();

  const auto x = static_cast<std::ptrdiff_t>(std::floor((io.MousePos.x - from.x) / scale));
  const auto y = static_cast<std::ptrdiff_t>(std::floor((io.MousePos.y - from.y) / scale));
  const bool inside = hovered && x >= 0 && y >= 0 && x < static_cast<std::ptrdiff_t>(picture.width) &&
                      y < static_cast<std::ptrdiff_t>(picture.height);
  if (inside) {
    const std::string value = ValueAt(picture, static_cast<std::size_t>(x), static_cast<std::size_t>(y));
    ImGui::Text("%td, %td: %s", x, y, value.c_str());
  } else {
    ImGui::TextDisabled("%zu x %zu %s", picture.width, picture.height, picture.encoding.c_str());
  }
}

}  // namespace hgros::viewer
