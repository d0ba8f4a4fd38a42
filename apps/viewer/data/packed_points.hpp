#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace hgros::viewer {

/// The points of one message in 8 bytes each: position in 3 x 16 bits of the box around them, a value in 16 bits of
/// its range. Exact to 1/130000 of the box.
struct PackedPoints {
  std::vector<std::array<std::uint16_t, 4>> points;
  Eigen::Vector3d corner = Eigen::Vector3d::Zero();  ///< The box's lower one.
  Eigen::Vector3f size = Eigen::Vector3f::Ones();    ///< Of the box, metres.
  float scalar_lo = 0;
  float scalar_hi = 1;
};

/// `scalars` is as long as `positions`, or empty.
[[nodiscard]] PackedPoints Pack(std::span<const Eigen::Vector3d> positions, std::span<const float> scalars);

}  // namespace hgros::viewer
