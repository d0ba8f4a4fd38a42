#pragma once

#include <span>
#include <vector>

#include "viewer/panels/dock/panel_place.hpp"

namespace hgros::viewer {

struct PanelSize {
  float width = 0;
  float height = 0;
};

/// Places of the panels that nobody has moved, in the order of `wanted`. While all fit, they are stacked from the lower
/// edge upwards with their wanted sizes. Otherwise they fill the space in rows of two. The widest panel gets its own
/// row if it needs one, or if the number of panels is odd.
[[nodiscard]] std::vector<PanelPlace> TilePanels(std::span<const PanelSize> wanted, const PanelPlace& room, float gap);

/// Places of images, from the lower right corner of the room, in the order of `images`: all in columns of equal width,
/// as large as possible. `images` has their sizes in pixels; only the proportions matter. A window is `frame` larger
/// than its image, and no image is wider than `widest`. They take at most `most` of the room's width.
[[nodiscard]] std::vector<PanelPlace> TileImages(std::span<const PanelSize> images, const PanelSize& frame,
                                                 float widest, float most, const PanelPlace& room, float gap);

}  // namespace hgros::viewer
