#pragma once

#include <Eigen/Geometry>

#include "viewer/data/shapes/scene_shapes.hpp"

namespace hgros::viewer {

/// The bounding box of the shapes, in the frame of their positions, without those that are far from all others
/// (BoundsOfMost).
[[nodiscard]] Eigen::AlignedBox3d BoundsOf(const SceneShapes& shapes);

}  // namespace hgros::viewer
