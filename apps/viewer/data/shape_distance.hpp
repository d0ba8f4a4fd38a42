#pragma once

#include <Eigen/Core>

#include "viewer/data/scene_shapes.hpp"

namespace hgros::viewer {

/// How far `at`, in the frame of the shapes, is from the surface of the nearest one, in metres; infinity: there is
/// none. Words, models and what has no alpha count for nothing. Of round shapes that are stretched it is an estimate,
/// which is exact on the surface.
[[nodiscard]] double DistanceTo(const SceneShapes& shapes, const Eigen::Vector3d& at);

/// How far a point is from a triangle, in metres.
[[nodiscard]] double DistanceToTriangle(const Eigen::Vector3d& at, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                        const Eigen::Vector3d& c);

}  // namespace hgros::viewer
