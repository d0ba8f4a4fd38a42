#pragma once

#include <Eigen/Geometry>
#include <string>

#include "foxglove/Color.pb.h"
#include "foxglove/Pose.pb.h"
#include "foxglove/SceneEntity.pb.h"
#include "viewer/data/shapes/scene_shapes.hpp"

namespace hgros::viewer {

/// Color channels are clamped to 0 and 1. Values that are not numbers become 0.
[[nodiscard]] Rgba ReadColor(const foxglove::Color& color);
/// Returns false if any part is not a finite number. A rotation of length 0, as in a message that does not set it,
/// becomes the identity.
[[nodiscard]] bool ReadPose(const foxglove::Pose& pose, Eigen::Isometry3d& T_parent_pose);

/// Adds an entity's primitives, in its frame, to `shapes`. Primitives that cannot be drawn are left out. Returns what
/// is wrong with the first of these, as a sentence, or nothing.
[[nodiscard]] std::string ReadScene(const foxglove::SceneEntity& entity, SceneShapes& shapes);

}  // namespace hgros::viewer
