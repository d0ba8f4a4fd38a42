#include "viewer/data/points/far_points.hpp"

#include "viewer/data/bounds_of_most.hpp"
#include "viewer/data/points/point_boxes.hpp"

namespace hgros::viewer {

void LeaveOutFar(PointBatch& batch) {
  const auto [all, most] = BoxesAround(batch.positions, kFarFromOthersMeters);
  if (all.isEmpty() || most.contains(all)) return;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < batch.positions.size(); ++i) {
    if (!most.contains(Eigen::Vector3d(batch.positions[i].cast<double>()))) continue;
    batch.positions[kept] = batch.positions[i];
    if (!batch.scalars.empty()) batch.scalars[kept] = batch.scalars[i];
    if (!batch.colors.empty()) batch.colors[kept] = batch.colors[i];
    ++kept;
  }
  batch.left_out += batch.positions.size() - kept;
  batch.positions.resize(kept);
  if (!batch.scalars.empty()) batch.scalars.resize(kept);
  if (!batch.colors.empty()) batch.colors.resize(kept);
}

}  // namespace hgros::viewer
