#include "viewer/data/points/packed_points.hpp"

#include <algorithm>
#include <cmath>

namespace hgros::viewer {

PackedBox BoxAround(const PlacedPoints& positions, std::span<const float> scalars) {
  PackedBox box;
  if (positions.empty()) return box;
  Eigen::Vector3d lo = positions[0];
  Eigen::Vector3d hi = lo;
  for (std::size_t i = 1; i < positions.size(); ++i) {
    const Eigen::Vector3d at = positions[i];
    lo = lo.cwiseMin(at);
    hi = hi.cwiseMax(at);
  }
  box.corner = lo;
  box.size = (hi - lo).cwiseMax(1e-6).cast<float>();
  bool any = false;
  for (const float value : scalars) {
    if (!std::isfinite(value)) continue;
    box.scalar_lo = any ? std::min(box.scalar_lo, value) : value;
    box.scalar_hi = any ? std::max(box.scalar_hi, value) : value;
    any = true;
  }
  if (box.scalar_hi <= box.scalar_lo) box.scalar_hi = box.scalar_lo + 1;
  return box;
}

void Pack(const PlacedPoints& positions, std::span<const float> scalars, const PackedBox& box,
          std::span<PackedPoint> packed) {
  const auto code = [](double unit) {
    return static_cast<std::uint16_t>(std::isfinite(unit) ? std::clamp(unit, 0.0, 1.0) * 65535 + 0.5 : 0);
  };
  const Eigen::Vector3d scale = box.size.cast<double>().cwiseInverse();
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Eigen::Vector3d unit = (positions[i] - box.corner).cwiseProduct(scale);
    const double scalar =
        scalars.empty() ? 0 : (static_cast<double>(scalars[i]) - box.scalar_lo) / (box.scalar_hi - box.scalar_lo);
    packed[i] = {code(unit.x()), code(unit.y()), code(unit.z()), code(scalar)};
  }
}

}  // namespace hgros::viewer
