#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "laser_scan.hpp"
#include "pose2.hpp"

namespace slam2d {

/// A wall, visible from both sides. Ends in m.
struct Wall {
  Point2 a;
  Point2 b;
};

struct SimulationOptions {
  std::uint64_t seed = 1;
  std::size_t scans = 1000;
  double scan_period_s = 0.1;
  double speed_m_per_s = 1.3;
  double turn_rate_rad_per_s = 1.8;  ///< At the corners of the route.
  std::size_t beams = 180;           ///< Over 180 degrees, the first at -90 degrees.
  double max_range_m = 30.0;
  double range_noise_m = 0.01;                     ///< Standard deviation.
  double odometry_noise_per_m = 0.04;              ///< Standard deviation of a step's length, per m of it.
  double odometry_noise_per_rad = 0.03;            ///< Standard deviation of a step's turn, per rad of it.
  double odometry_heading_bias_rad_per_m = 0.006;  ///< As from a wheel that is slightly too small.
};

/// Independent numbers that are equal on every platform: the standard specifies std::mt19937_64 to the bit, but not its
/// distributions.
class SeededNoise {
 public:
  explicit SeededNoise(std::uint64_t seed) : bits_(seed) {}

  /// In [0, 1), a multiple of 2^-53.
  double Uniform();

  /// Mean 0, standard deviation 1: the sum of twelve uniform numbers minus 6, which needs no libm.
  double Normal();

 private:
  std::mt19937_64 bits_;
};

/// A building of 20 m x 14 m and a robot that drives through it: a ring of corridors, offices with open doors outside
/// and inside the ring, some furniture. The robot drives around the ring and visits some offices. The route is closed
/// and is repeated until the scans are used up. Equal options give equal scans, bit for bit.
///
/// The map frame is the building's, its corner at (0, 0). Odometry starts at the true pose and drifts.
/// Threading: one thread at a time.
class SimulatedBuilding {
 public:
  explicit SimulatedBuilding(const SimulationOptions& options = {});

  /// False once options.scans scans have been returned.
  [[nodiscard]] bool Next(LaserScan2& scan);

  /// Pose of the laser at the last returned scan.
  [[nodiscard]] const Pose2& true_pose() const { return T_building_laser_; }

  [[nodiscard]] const std::vector<Wall>& walls() const { return walls_; }

  /// Distance to the nearest wall along a ray, at most `max_range_m`.
  [[nodiscard]] double Range(const Point2& from, double angle_rad, double max_range_m) const;

 private:
  void Advance();

  SimulationOptions options_;
  SeededNoise noise_;
  std::vector<Wall> walls_;
  std::vector<Point2> route_;
  std::size_t next_corner_ = 1;
  std::uint64_t next_sequence_ = 0;
  Pose2 T_building_laser_;
  Pose2 T_odometry_laser_;
};

}  // namespace slam2d
