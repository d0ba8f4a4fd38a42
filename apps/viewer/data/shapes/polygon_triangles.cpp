#include "viewer/data/shapes/polygon_triangles.hpp"

#include <algorithm>
#include <numeric>

namespace hgros::viewer {
namespace {

using Eigen::Vector2d;

constexpr std::size_t kMaxCorners = 10'000;

// Twice the area of the triangle; positive if it is counter-clockwise.
double Turn(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

// Inside or on the border.
bool Covers(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& p) {
  return Turn(a, b, p) >= 0 && Turn(b, c, p) >= 0 && Turn(c, a, p) >= 0;
}

}  // namespace

std::vector<std::array<std::uint32_t, 3>> TrianglesOf(std::span<const Vector2d> corners) {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  const bool finite = std::ranges::all_of(corners, [](const Vector2d& corner) { return corner.allFinite(); });
  if (corners.size() < 3 || corners.size() > kMaxCorners || !finite) return triangles;
  std::vector<std::uint32_t> left(corners.size());
  std::iota(left.begin(), left.end(), 0U);
  double area = 0;
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) area += Turn(corners[0], corners[i], corners[i + 1]);
  if (area < 0) std::ranges::reverse(left);

  std::size_t at = 0;
  std::size_t without_ear = 0;
  while (left.size() >= 3) {
    const std::size_t n = left.size();
    const std::uint32_t before = left[(at + n - 1) % n], here = left[at % n], after = left[(at + 1) % n];
    const Vector2d &a = corners[before], &b = corners[here], &c = corners[after];
    const double turn = Turn(a, b, c);
    // If a whole round finds no ear, the polygon crosses itself, and any corner is cut off.
    const bool forced = without_ear > n;
    bool ear = turn > 0;
    for (std::size_t i = 0; ear && !forced && i < n; ++i) {
      const Vector2d& p = corners[left[i]];
      if (left[i] == before || left[i] == here || left[i] == after || p == a || p == b || p == c) continue;
      ear = !Covers(a, b, c, p);
    }
    if (ear || forced || turn == 0) {  // A corner on a straight line or of a needle gives no triangle.
      if (turn > 0) triangles.push_back({before, here, after});
      left.erase(left.begin() + static_cast<std::ptrdiff_t>(at % n));
      at = (at + left.size() - 1) % std::max<std::size_t>(left.size(), 1);
      without_ear = 0;
    } else {
      at = (at + 1) % n;
      ++without_ear;
    }
  }
  return triangles;
}

}  // namespace hgros::viewer
