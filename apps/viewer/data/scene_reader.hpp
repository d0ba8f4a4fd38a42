#pragma once

#include <Eigen/Geometry>
#include <string>

#include "foxglove/Color.pb.h"
#include "foxglove/Pose.pb.h"
#include "foxglove/SceneEntity.pb.h"
#include "viewer/data/scene_shapes.hpp"

namespace hgros::viewer {

/// Channels below 0 and above 1 are cut, what is no number counts as 0.
[[nodiscard]] Rgba ReadColor(const foxglove::Color& color);
/// False if some part of it is no finite number. A rotation of length 0, as of a message that says none, is none.
[[nodiscard]] bool ReadPose(const foxglove::Pose& pose, Eigen::Isometry3d& T_parent_pose);

/// Adds an entity's primitives, in its frame, to `shapes`. Returns what is wrong with the first one that cannot be
/// drawn, in a sentence; the others are added all the same.
[[nodiscard]] std::string ReadScene(const foxglove::SceneEntity& entity, SceneShapes& shapes);

}  // namespace hgros::viewer
