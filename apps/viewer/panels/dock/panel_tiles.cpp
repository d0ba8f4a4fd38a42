#include "viewer/panels/dock/panel_tiles.hpp"

#include <algorithm>
#include <cstddef>

namespace hgros::viewer {
namespace {

constexpr float kTooNarrow = 1.4F;  ///< A panel that is wider than this many half rows gets a whole row.

/// Which panels are beside each other, from the top.
std::vector<std::vector<std::size_t>> RowsOf(std::span<const PanelSize> wanted, float half) {
  std::vector<std::vector<std::size_t>> rows;
  const auto widest =
      static_cast<std::size_t>(std::ranges::max_element(wanted, {}, &PanelSize::width) - wanted.begin());
  const bool alone = wanted.size() % 2 == 1 || wanted[widest].width > kTooNarrow * half;
  if (alone) rows.push_back({widest});
  bool opens = true;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (alone && i == widest) continue;
    if (opens || wanted.size() == 2) rows.emplace_back();
    rows.back().push_back(i);
    opens = !opens;
  }
  return rows;
}

}  // namespace

std::vector<PanelPlace> TilePanels(std::span<const PanelSize> wanted, const PanelPlace& room, float gap) {
  std::vector<PanelPlace> places(wanted.size());
  if (wanted.empty()) return places;
  float height = -gap;
  for (const PanelSize& size : wanted) height += size.height + gap;
  if (height <= room.height) {
    float lower = room.y + room.height;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      places[i] = {room.x, lower - wanted[i].height, std::min(wanted[i].width, room.width), wanted[i].height};
      lower = places[i].y - gap;
    }
    return places;
  }
  const auto rows = RowsOf(wanted, 0.5F * (room.width - gap));
  const auto count = static_cast<float>(rows.size());
  const float row_height = (room.height - (count - 1) * gap) / count;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const auto beside = static_cast<float>(rows[r].size());
    const float width = (room.width - (beside - 1) * gap) / beside;
    for (std::size_t c = 0; c < rows[r].size(); ++c) {
      places[rows[r][c]] = {room.x + static_cast<float>(c) * (width + gap),
                            room.y + static_cast<float>(r) * (row_height + gap), width, row_height};
    }
  }
  return places;
}

std::vector<PanelPlace> TileImages(std::span<const PanelSize> images, const PanelSize& frame, float widest, float most,
                                   const PanelPlace& room, float gap) {
  std::vector<PanelPlace> places(images.size());
  float best = -1;
  for (std::size_t columns = 1; columns <= images.size(); ++columns) {
    const std::size_t rows = (images.size() + columns - 1) / columns;
    const auto beside = static_cast<float>(columns);
    const auto above = static_cast<float>(rows);
    const float width = std::min((most - (beside - 1) * gap) / beside, widest + frame.width);
    const float row = (room.height - (above - 1) * gap) / above;
    float area = 0;
    std::vector<PanelSize> shown;
    for (const PanelSize& image : images) {
      const float scale =
          std::max(0.0F, std::min((width - frame.width) / image.width, (row - frame.height) / image.height));
      shown.push_back({scale * image.width, scale * image.height});
      area += shown.back().width * shown.back().height;
    }
    if (area <= best) continue;
    best = area;
    const float needed = std::ranges::max_element(shown, {}, &PanelSize::width)->width + frame.width;
    float lower = 0;
    for (std::size_t i = 0; i < images.size(); ++i) {
      if (i % rows == 0) lower = room.y + room.height;
      const float height = shown[i].height + frame.height;
      const std::size_t columns_before = i / rows;
      const auto column = static_cast<float>(columns_before);
      places[i] = {room.x + room.width - needed - column * (needed + gap), lower - height, needed, height};
      lower -= height + gap;
    }
  }
  return places;
}

}  // namespace hgros::viewer
