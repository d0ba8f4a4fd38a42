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

}  // namespace hgros::viewer
