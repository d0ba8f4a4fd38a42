#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace hgros::viewer {

/// Cuts a polygon that does not cross itself, convex or not, in either direction, into triangles of its corners
/// (counter-clockwise): ears are cut off until three corners are left. A polygon that crosses itself gives triangles
/// that overlap; one without area gives none. Quadratic, so `corners` of more than 10000 are refused (no triangles).
[[nodiscard]] std::vector<std::array<std::uint32_t, 3>> TrianglesOf(std::span<const Eigen::Vector2d> corners);

}  // namespace hgros::viewer
