#pragma once

#include <span>
#include <vector>

#include "viewer/panels/panel_place.hpp"

namespace hgros::viewer {

struct PanelSize {
  float width = 0;
  float height = 0;
};

/// Where panels lie that nobody has placed: above each other from the lower edge of the room up, as large as they want
/// to be, while all fit; else in rows that fill it, two in each, where the widest has a row of its own if it needs one
/// or there is one too many. In the order of `wanted`.
[[nodiscard]] std::vector<PanelPlace> TilePanels(std::span<const PanelSize> wanted, const PanelPlace& room, float gap);

}  // namespace hgros::viewer
