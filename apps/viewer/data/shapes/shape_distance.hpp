#pragma once

#include <Eigen/Core>

#include "viewer/data/shapes/scene_shapes.hpp"

namespace hgros::viewer {

/// Distance from `at`, in the frame of the shapes, to the nearest surface, in meters. Infinity if there is none. Texts,
/// models and transparent shapes are ignored. For stretched round shapes it is an estimate that is exact on the
/// surface.
[[nodiscard]] double DistanceTo(const SceneShapes& shapes, const Eigen::Vector3d& at);

/// Distance from a point to a triangle, in meters.
[[nodiscard]] double DistanceToTriangle(const Eigen::Vector3d& at, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                        const Eigen::Vector3d& c);

}  // namespace hgros::viewer
