#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace hgros::viewer {

/// Cuts a polygon into counter-clockwise triangles by ear clipping. The polygon may be concave and may have either
/// direction. If it crosses itself, triangles overlap. If it has no area, there are none. The time is quadratic, so
/// more than 10,000 corners give no triangles.
[[nodiscard]] std::vector<std::array<std::uint32_t, 3>> TrianglesOf(std::span<const Eigen::Vector2d> corners);

}  // namespace hgros::viewer
