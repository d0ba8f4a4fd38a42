#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>

namespace hgros::viewer {

/// A position inside a cube in 32 bits: 11 for x, 11 for y, 10 for z, counted from the lower corner. Decoding gives the
/// middle of a step, so the error is at most 1/4096 of the cube's edge (z: 1/2048).
namespace cell_code {

inline constexpr std::uint32_t kStepsXY = 2048;
inline constexpr std::uint32_t kStepsZ = 1023;          // The last code of z is unused ...
inline constexpr std::uint32_t kNowhere = 0xFFFFFFFFU;  // ... so this code is never a position.

/// `in_cell` in units of the edge, 0 to 1.
[[nodiscard]] inline std::uint32_t Encode(const Eigen::Vector3d& in_cell) noexcept {
  const auto step = [](double value, std::uint32_t steps) {
    const double scaled = std::floor(value * steps);
    return static_cast<std::uint32_t>(std::clamp(scaled, 0.0, static_cast<double>(steps - 1)));
  };
  return step(in_cell.x(), kStepsXY) | step(in_cell.y(), kStepsXY) << 11U | step(in_cell.z(), kStepsZ) << 22U;
}

[[nodiscard]] inline Eigen::Vector3d Decode(std::uint32_t code) noexcept {
  return {(code % kStepsXY + 0.5) / kStepsXY, ((code >> 11U) % kStepsXY + 0.5) / kStepsXY,
          ((code >> 22U) + 0.5) / kStepsZ};
}

}  // namespace cell_code
}  // namespace hgros::viewer
