#include "viewer/data/points/far_points.hpp"

#include <utility>

#include "viewer/data/bounds_of_most.hpp"

namespace hgros::viewer {

void LeaveOutFar(PointBatch& batch) {
  if (batch.positions.empty()) return;
  Eigen::Vector3f lo = batch.positions.front();
  Eigen::Vector3f hi = lo;
  for (const Eigen::Vector3f& at : batch.positions) {
    lo = lo.cwiseMin(at);
    hi = hi.cwiseMax(at);
  }
  if ((hi - lo).maxCoeff() <= static_cast<float>(kFarFromOthersMeters)) return;
  std::vector<Eigen::AlignedBox3d> boxes;
  boxes.reserve(batch.positions.size());
  for (const Eigen::Vector3f& at : batch.positions) boxes.emplace_back(Eigen::Vector3d(at.cast<double>()));
  const Eigen::AlignedBox3d most = BoundsOfMost(std::move(boxes));
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
