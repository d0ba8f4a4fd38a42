#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "laser_scan.hpp"
#include "pose2.hpp"

namespace slam2d {

/// A wall, seen from both sides; ends in m.
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
  double odometry_heading_bias_rad_per_m = 0.006;  ///< A wheel that is a little too small.
};

/// Independent numbers that are equal on every platform: std::mt19937_64 is specified to the bit, the standard's
/// distributions are not.
class SeededNoise {
 public:
  explicit SeededNoise(std::uint64_t seed) : bits_(seed) {}

  /// In [0, 1), a multiple of 2^-53.
  double Uniform();

  /// Mean 0, standard deviation 1: the sum of twelve uniform numbers less 6, which needs no libm.
  double Normal();

 private:
  std::mt19937_64 bits_;
};

/// A building of 20 m x 14 m and a robot on its rounds in it: a ring of corridors, offices with open doors outside and
/// inside of the ring, some furniture. The robot goes round and looks into some offices; the route is closed and
/// passed again until the scans are used up. Equal options give equal scans, bit for bit.
///
/// The map frame is the building's, its corner at (0, 0). Odometry starts at the true pose and drifts.
/// Threading: one thread at a time.
class SimulatedBuilding {
 public:
  explicit SimulatedBuilding(const SimulationOptions& options = {});

  /// False when options.scans scans were given.
  [[nodiscard]] bool Next(LaserScan2& scan);

  /// Where the laser was at the scan given last.
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
