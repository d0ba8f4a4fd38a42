#pragma once

#include <cstdint>
#include <vector>

#include "pose2.hpp"

namespace slam2d {

/// One turn of a planar laser scanner.
///
/// Beam i looks along `start_angle_rad + i * angle_step_rad`, counter-clockwise from the laser's x axis.
struct LaserScan2 {
  std::uint64_t sequence = 0;  ///< Position in the source, from 0 without gaps.
  double stamp_seconds = 0.0;  ///< As in the source; may step back (it does in the Intel log).
  double start_angle_rad = 0.0;
  double angle_step_rad = 0.0;
  double max_range_m = 0.0;  ///< A range at or above it means "no return".
  std::vector<float> ranges_m;
  Pose2 odometry;  ///< Pose of the laser in the odometry frame, T_odometry_laser.
};

}  // namespace slam2d
