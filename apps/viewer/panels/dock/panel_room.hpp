#pragma once

#include "viewer/panels/dock/panel_place.hpp"

namespace hgros::viewer {

/// The space for images and panels: beside the list of displays, below the panel View while that is folded, and above
/// the time bar. It has at least the size of a small panel.
[[nodiscard]] PanelPlace PanelRoom();

}  // namespace hgros::viewer
