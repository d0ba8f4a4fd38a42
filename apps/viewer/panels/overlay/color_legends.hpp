#pragma once

#include "viewer/scene/scene.hpp"

namespace hgros::viewer {

/// Draws the color maps of the visible displays with their limits into the lower left corner of FreeRoom.
void DrawColorLegends(const Scene& scene);

}  // namespace hgros::viewer
