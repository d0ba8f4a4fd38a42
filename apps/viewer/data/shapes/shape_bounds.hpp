#pragma once

#include <Eigen/Geometry>

#include "viewer/data/shapes/scene_shapes.hpp"

namespace hgros::viewer {

/// The bounding box of all shapes, in the frame of their positions.
[[nodiscard]] Eigen::AlignedBox3d BoundsOf(const SceneShapes& shapes);

}  // namespace hgros::viewer
