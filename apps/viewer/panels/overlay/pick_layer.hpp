#pragma once

#include "viewer/view/camera.hpp"
#include "viewer/view/point_picks.hpp"

namespace hgros::viewer {

/// Marks picked points in the scene and the line between two with its length. A window describes them; closing it
/// clears the points. `pixels_per_unit`: screen pixels per unit of ImGui's coordinates.
void DrawPicks(PointPicks& picks, const Camera& camera, const Viewport& viewport, float pixels_per_unit);

}  // namespace hgros::viewer
