#include <foxglove/PointCloud.pb.h>

#include "hgros/clock/time.hpp"
#include "hgros/tf/transform_cloud.hpp"
#include "sides.hpp"

namespace hgros::bench {

double CloudPointsPerSecond(int points, int rounds) {
  constexpr std::uint32_t kStride = 16;
  Bulk<foxglove::PointCloud> cloud(static_cast<std::size_t>(points) * kStride);
  cloud.head().set_point_stride(kStride);
  for (const auto& [name, offset] :
       {std::pair("x", 0U), std::pair("y", 4U), std::pair("z", 8U), std::pair("intensity", 12U)}) {
    auto& field = *cloud.head().add_fields();
    field.set_name(name);
    field.set_offset(offset);
    field.set_type(foxglove::PackedElementField::FLOAT32);
  }
  for (std::size_t i = 0; i < cloud.size(); i += sizeof(float)) {
    const float value = static_cast<float>(i % 1000) * 0.01F;
    std::memcpy(cloud.writable().data() + i, &value, sizeof value);
  }
  const RigidTransform turn{RigidTransform::Rotation(Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitZ())),
                            Eigen::Vector3d(0.01, 0, 0)};
  const std::int64_t start = MonotonicNow();
  for (int i = 0; i < rounds; ++i) {
    if (!TransformCloud(turn, "map", cloud).empty()) return 0;
  }
  return static_cast<double>(points) * rounds / static_cast<double>(MonotonicNow() - start) * 1e9;
}

}  // namespace hgros::bench
