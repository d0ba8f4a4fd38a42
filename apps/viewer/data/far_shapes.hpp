#pragma once

#include <cstddef>

#include "viewer/data/scene_shapes.hpp"

namespace hgros::viewer {

/// Farther away, or larger, is nothing that is shown: a single one would leave no precision to the others.
inline constexpr double kFarthestMetres = 1e9;

/// Leaves out what is farther away or larger than that, or lies at no number. How many there were.
std::size_t LeaveOutFar(SceneShapes& shapes);

}  // namespace hgros::viewer
