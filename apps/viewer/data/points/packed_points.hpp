#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

#include "viewer/data/points/placed_points.hpp"

namespace hgros::viewer {

/// A point in 8 bytes: its position as 3 x 16 bits relative to the bounding box of its message, and a value as 16 bits
/// relative to its range. The error is at most 1/130000 of the box.
using PackedPoint = std::array<std::uint16_t, 4>;

/// The box and range of the codes of one message.
struct PackedBox {
  Eigen::Vector3d corner = Eigen::Vector3d::Zero();  ///< The lower corner of the box.
  Eigen::Vector3f size = Eigen::Vector3f::Ones();    ///< Meters.
  float scalar_lo = 0;
  float scalar_hi = 1;
};

/// `scalars` is as long as `positions`, or empty.
[[nodiscard]] PackedBox BoxAround(const PlacedPoints& positions, std::span<const float> scalars);

/// Writes each point once, in order. `packed` is as long as `positions`.
void Pack(const PlacedPoints& positions, std::span<const float> scalars, const PackedBox& box,
          std::span<PackedPoint> packed);

}  // namespace hgros::viewer
