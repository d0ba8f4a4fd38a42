#include "viewer/panels/image_panel.hpp"

#include <imgui.h>
#include <imgui_internal.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include "viewer/panels/dock/panel_tiles.hpp"

namespace hgros::viewer {
namespace {

constexpr float kMostOfRoom = 0.5F;  // images that nobody has moved take at most this part of the room's width
constexpr float kMostZoom = 200;
constexpr float kWheelFactor = 1.2F;
// In heights of the font.
constexpr float kWidestImage = 24;
constexpr float kNarrowestImages = 4;
constexpr float kImageGap = 0.4F;

}  // namespace

std::vector<ImagePanel::Shown> ImagePanel::ShownImages(const Scene& scene) {
  std::erase_if(windows_, [&](const auto& window) {
    return std::ranges::none_of(scene.entries(),
                                [&](const Scene::Entry& entry) { return entry.display.get() == window.first; });
  });
  std::vector<Shown> all;
  for (const Scene::Entry& entry : scene.entries()) {
    const auto image = entry.visible ? entry.display->Image() : std::nullopt;
    if (!image) continue;
    ImageWindow& window = windows_[entry.display.get()];
    if (window.number == 0) window.number = ++numbers_;
    all.push_back({&entry, *image, &window});
  }
  return all;
}

std::optional<PanelPlace> ImagePanel::PlaceOf(const Display& display) const {
  const auto found = windows_.find(&display);
  if (found == windows_.end()) return std::nullopt;
  const ImageWindow& window = found->second;
  if (window.wanted || !window.window.by_hand()) return window.wanted;
  return window.window.place();
}

PanelPlace ImagePanel::Draw(const Scene& scene, const PanelPlace& room, float reserved) {
  const float unit = ImGui::GetFontSize();
  const float gap = kImageGap * unit;
  const std::vector<Shown> all = ShownImages(scene);
  std::vector<PanelSize> tiled;
  for (const Shown& shown : all) {
    if (shown.window->wanted || shown.window->window.by_hand()) continue;
    const ImagePicture& picture = *shown.image.picture;
    tiled.push_back({static_cast<float>(picture.width), static_cast<float>(picture.height)});
  }
  const ImGuiStyle& style = ImGui::GetStyle();
  const PanelSize frame{2 * style.WindowPadding.x,
                        ImGui::GetFrameHeight() + 2 * style.WindowPadding.y + ImGui::GetTextLineHeightWithSpacing()};
  const float free = reserved > 0 ? room.width - reserved - gap : room.width;
  const float most = std::max(kNarrowestImages * unit, std::min(kMostOfRoom * room.width, free));
  const std::vector<PanelPlace> tiles = TileImages(tiled, frame, kWidestImage * unit, most, room, gap);
  auto tile = tiles.begin();
  PanelPlace rest = room;
  for (const Shown& shown : all) {
    const bool by_hand = shown.window->wanted || shown.window->window.by_hand();
    DrawWindow(shown, by_hand ? PanelPlace() : *tile);
    if (by_hand) continue;
    rest.width = std::min(rest.width, tile->x - gap - room.x);
    ++tile;
  }
  return rest;
}

void ImagePanel::DrawWindow(const Shown& shown, const PanelPlace& tile) {
  ImageWindow& window = *shown.window;
  if (window.wanted) {
    window.window.PlaceByHand(*window.wanted);
    window.wanted.reset();
  } else {
    window.window.Place(tile);
  }
  const std::string title = shown.entry->name + "##image " + std::to_string(window.number);
  if (ImGui::Begin(title.c_str(), nullptr,
                   ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoScrollbar |
                       ImGuiWindowFlags_NoScrollWithMouse | ImGuiWindowFlags_NoFocusOnAppearing)) {
    DrawImage(shown);
  }
  // It covers nothing that a user has placed.
  if (ImGui::IsWindowAppearing() && !window.window.by_hand()) {
    ImGui::BringWindowToDisplayBack(ImGui::GetCurrentWindow());
  }
  window.window.Note();
  ImGui::End();
}

void ImagePanel::DrawImage(const Shown& shown) {
  ImageWindow& part = *shown.window;
  const ImagePicture& picture = *shown.image.picture;
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
    part.zoom = 1;
    part.middle_x = part.middle_y = 0.5F;
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
  const auto texture =
      reinterpret_cast<ImTextureID>(static_cast<std::uintptr_t>(shown.image.texture));  // NOLINT: ImGui's way
  list.AddImage(texture, from, {from.x + width * scale, from.y + height * scale});
  list.PopClipRect();

  const float right = (io.MousePos.x - from.x) / scale;
  const float down = (io.MousePos.y - from.y) / scale;
  if (hovered && right >= 0 && down >= 0 && right < width && down < height) {
    const auto x = static_cast<std::size_t>(right);
    const auto y = static_cast<std::size_t>(down);
    ImGui::Text("%zu, %zu: %s", x, y, shown.entry->display->PixelText(x, y).c_str());
  } else {
    ImGui::TextDisabled("%zu x %zu %s", picture.width, picture.height, picture.encoding.c_str());
  }
}

}  // namespace hgros::viewer
