#pragma once

#include <string>

#include "viewer/panels/dock/panel_place.hpp"

namespace hgros::viewer {

/// Writes what the viewer waits for into the room, behind all panels: the first sentence bright, the second one gray.
void DrawAwaited(const std::string& awaited, const std::string& reach, const PanelPlace& room);

}  // namespace hgros::viewer
