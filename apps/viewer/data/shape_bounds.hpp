#pragma once

#include <Eigen/Geometry>

#include "viewer/data/scene_shapes.hpp"

namespace hgros::viewer {

/// The box about everything, in the frame of the positions; empty if there is nothing.
[[nodiscard]] Eigen::AlignedBox3d BoundsOf(const SceneShapes& shapes);

}  // namespace hgros::viewer
