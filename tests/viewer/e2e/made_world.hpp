#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "foxglove/LaserScan.pb.h"
#include "foxglove/PointCloud.pb.h"
#include "foxglove/PosesInFrame.pb.h"
#include "foxglove/SceneUpdate.pb.h"
#include "hgros/codec/bulk.hpp"
#include "hgros/tf/rigid_transform.hpp"

namespace hgros::viewer::test {

/// A street with houses that a robot drives along, for pictures that are the same in every run.
namespace made_world {

/// The robot's pose after `step` steps of 0.5 m.
[[nodiscard]] RigidTransform PoseAt(std::size_t step);
/// The points that its sensor measures there: x, y, z, intensity as floats.
[[nodiscard]] std::unique_ptr<Bulk<foxglove::PointCloud>> CloudAt(std::size_t step, std::size_t points,
                                                                  std::int64_t stamp_ns);
[[nodiscard]] foxglove::LaserScan ScanAt(std::size_t step, std::int64_t stamp_ns);
/// The path until then, in "map".
[[nodiscard]] foxglove::PosesInFrame TrajectoryUntil(std::size_t step, std::int64_t stamp_ns);
/// The robot's body, locked to "base", an arrow along its path and its name, each for a second, and a post every 50 m
/// of the path so far.
[[nodiscard]] foxglove::SceneUpdate ThingsAt(std::size_t step, std::int64_t stamp_ns);

}  // namespace made_world
}  // namespace hgros::viewer::test
