#pragma once

#include <span>

#include "viewer/scene/display.hpp"
#include "viewer/view/camera.hpp"

namespace hgros::viewer {

/// Draws the first thousand visible labels at their places in the scene, behind all panels, and the anchor. Labels of
/// the usual height that would overlap are listed below each other. `pixels_per_unit`: screen pixels per unit of
/// ImGui's coordinates.
void DrawLabels(std::span<const Label> labels, const Camera& camera, const Viewport& viewport, float pixels_per_unit);

}  // namespace hgros::viewer
