#pragma once

#include <cmath>
#include <string_view>

#include <hgros/clock/time.hpp>
#include <hgros/tf/rigid_transform.hpp>

#include "../pose2.hpp"

/// The frames of the robot, from the map down. Each edge has one node that sets it.
///
///     map --matcher--> odom --source--> base --source, static--> laser
namespace slam2d {

inline constexpr std::string_view kMapFrame = "map";
inline constexpr std::string_view kOdomFrame = "odom";
inline constexpr std::string_view kBaseFrame = "base";
inline constexpr std::string_view kLaserFrame = "laser";

/// The logs contain no pose of the laser on the robot. It is assumed at the robot's center.
inline constexpr Pose2 kBaseLaser{};

[[nodiscard]] inline hgros::RigidTransform RigidOf(const Pose2& pose) {
  return {{std::cos(0.5 * pose.theta), 0, 0, std::sin(0.5 * pose.theta)}, {pose.x, pose.y, 0}};
}

[[nodiscard]] inline Pose2 PlanarOf(const hgros::RigidTransform& T) {
  return {T.translation.x(), T.translation.y(), 2 * std::atan2(T.rotation.z(), T.rotation.w())};
}

/// Log stamps count seconds; a Time counts nanoseconds.
[[nodiscard]] inline hgros::Time TimeOf(double stamp_seconds) {
  return {static_cast<std::int64_t>(std::llround(stamp_seconds * 1e9))};
}

}  // namespace slam2d
