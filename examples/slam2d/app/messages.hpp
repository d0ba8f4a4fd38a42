#pragma once

#include <slam2d.pb.h>

#include "../laser_scan.hpp"
#include "../occupancy_map.hpp"
#include "../scan_matcher.hpp"

/// The core's values as messages and back, without losing a bit.
///
/// Errors: reading throws std::invalid_argument if a message contradicts itself.
namespace slam2d {

void Write(const LaserScan2& scan, msg::Scan& message);
void Write(const ScanMatch& match, msg::Match& message);
void Write(const Pose2& pose, msg::Pose& message);
/// All but match, odometry and layout.
void Write(const MapDelta& delta, msg::MapUpdate& message);
/// What does not change of the options.
void Write(const MapOptions& options, msg::MapLayout& message);

[[nodiscard]] LaserScan2 Read(const msg::Scan& message);
[[nodiscard]] ScanMatch Read(const msg::Match& message);
[[nodiscard]] Pose2 Read(const msg::Pose& message);
/// Everything else as it is by default.
[[nodiscard]] MapOptions Read(const msg::MapLayout& message);
[[nodiscard]] MapDelta Read(const msg::MapUpdate& message);

}  // namespace slam2d
