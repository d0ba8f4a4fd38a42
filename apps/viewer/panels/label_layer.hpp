#pragma once

#include <span>

#include "viewer/scene/display.hpp"
#include "viewer/view/camera.hpp"

namespace hgros::viewer {

/// Writes words beside their places in the scene, behind all panels, those of the first thousand that
/// are in view; usual ones that would lie over each other are listed below each other. And marks the anchor.
/// `pixels_per_unit` is of the screen to ImGui's coordinates.
void DrawLabels(std::span<const Label> labels, const Camera& camera, const Viewport& viewport, float pixels_per_unit);

}  // namespace hgros::viewer
