#include "viewer/data/packed_points.hpp"

#include <algorithm>
#include <cmath>

namespace hgros::viewer {

PackedPoints Pack(std::span<const Eigen::Vector3d> positions, std::span<const float> scalars) {
  PackedPoints packed;
  if (positions.empty()) return packed;
  Eigen::Vector3d lo = positions.front();
  Eigen::Vector3d hi = lo;
  for (const Eigen::Vector3d& at : positions) {
    lo = lo.cwiseMin(at);
    hi = hi.cwiseMax(at);
  }
  packed.corner = lo;
  packed.size = (hi - lo).cwiseMax(1e-6).cast<float>();
  bool any = false;
  for (const float value : scalars) {
    if (!std::isfinite(value)) continue;
    packed.scalar_lo = any ? std::min(packed.scalar_lo, value) : value;
    packed.scalar_hi = any ? std::max(packed.scalar_hi, value) : value;
    any = true;
  }
  if (packed.scalar_hi <= packed.scalar_lo) packed.scalar_hi = packed.scalar_lo + 1;

  const auto code = [](double unit) {
    return static_cast<std::uint16_t>(std::isfinite(unit) ? std::clamp(unit, 0.0, 1.0) * 65535 + 0.5 : 0);
  };
  packed.points.reserve(positions.size());
  const Eigen::Vector3d scale = packed.size.cast<double>().cwiseInverse();
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Eigen::Vector3d unit = (positions[i] - lo).cwiseProduct(scale);
    const double scalar =
        scalars.empty() ? 0
                        : (static_cast<double>(scalars[i]) - packed.scalar_lo) / (packed.scalar_hi - packed.scalar_lo);
    packed.points.push_back({code(unit.x()), code(unit.y()), code(unit.z()), code(scalar)});
  }
  return packed;
}

}  // namespace hgros::viewer
