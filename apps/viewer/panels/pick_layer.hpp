#pragma once

#include "viewer/view/camera.hpp"
#include "viewer/view/point_picks.hpp"

namespace hgros::viewer {

/// Marks picked points in the scene, the line between two with its length, and says what they are in a window, which
/// forgets them when it is closed. `pixels_per_unit` is of the screen to ImGui's coordinates.
void DrawPicks(PointPicks& picks, const Camera& camera, const Viewport& viewport, float pixels_per_unit);

}  // namespace hgros::viewer
