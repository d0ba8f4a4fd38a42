#pragma once

#include <slam2d.pb.h>

#include "../laser_scan.hpp"
#include "../occupancy_map.hpp"
#include "../scan_matcher.hpp"

/// Converts the core's values to messages and back, without loss.
///
/// Errors: reading throws std::invalid_argument if a message is inconsistent.
namespace slam2d {

void Write(const LaserScan2& scan, msg::Scan& message);
void Write(const ScanMatch& match, msg::Match& message);
void Write(const Pose2& pose, msg::Pose& message);
/// Everything except match, odometry and layout.
void Write(const MapDelta& delta, msg::MapUpdate& message);
/// The options that never change.
void Write(const MapOptions& options, msg::MapLayout& message);

[[nodiscard]] LaserScan2 Read(const msg::Scan& message);
[[nodiscard]] ScanMatch Read(const msg::Match& message);
[[nodiscard]] Pose2 Read(const msg::Pose& message);
/// All other options have their defaults.
[[nodiscard]] MapOptions Read(const msg::MapLayout& message);
[[nodiscard]] MapDelta Read(const msg::MapUpdate& message);

}  // namespace slam2d
