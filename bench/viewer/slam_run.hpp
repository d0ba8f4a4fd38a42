#pragma once

#include <cstddef>
#include <vector>

/// A robot that goes round a yard with a lidar, the same in every run and for every viewer. Knows no middleware.
namespace hgros::bench::slam_run {

struct Pose {
  double x;
  double y;
  double z;
  double yaw;
};

/// Where the lidar is, seen from the base.
inline constexpr Pose kLidar{0.2, 0, 1.2, 0};

/// The base in the map, so many seconds after the start: about 1 m/s.
[[nodiscard]] Pose PoseAt(double seconds);

/// What the lidar sees from there: x, y, z, intensity of `points` points, in its own frame. `turn` makes the noise.
[[nodiscard]] std::vector<float> ScanFrom(const Pose& base, std::size_t points, std::size_t turn);

}  // namespace hgros::bench::slam_run
