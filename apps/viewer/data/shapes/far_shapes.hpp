#pragma once

#include <cstddef>

#include "viewer/data/shapes/scene_shapes.hpp"

namespace hgros::viewer {

/// Shapes that are farther away or larger are not shown: a single one would take the precision of all others.
inline constexpr double kFarthestMeters = 1e9;

/// Removes shapes that are too far away, too large, or have coordinates that are not numbers. Returns their number.
std::size_t LeaveOutFar(SceneShapes& shapes);

}  // namespace hgros::viewer
