#pragma once

#include <cstddef>
#include <vector>

/// A robot that drives around a yard with a lidar, the same in every run and for every viewer. Uses no middleware.
namespace hgros::bench::slam_run {

struct Pose {
  double x;
  double y;
  double z;
  double yaw;
};

/// Pose of the lidar in the base.
inline constexpr Pose kLidar{0.2, 0, 1.2, 0};

/// Pose of the base in the map at this many seconds after the start; moves at about 1 m/s.
[[nodiscard]] Pose PoseAt(double seconds);

/// The lidar's view from there: x, y, z, intensity of `points` points, in its frame. `turn` seeds the noise.
[[nodiscard]] std::vector<float> ScanFrom(const Pose& base, std::size_t points, std::size_t turn);

}  // namespace hgros::bench::slam_run
