#include "scan_cloud.hpp"

#include <cstdint>
#include <cstring>

namespace hgros::bench::slam_run {

void WriteScan(std::span<const float> scan, const std::string& frame, Bulk<foxglove::PointCloud>& cloud) {
  foxglove::PointCloud& head = cloud.head();
  head.set_frame_id(frame);
  std::uint32_t offset = 0;
  for (const char* name : {"x", "y", "z", "intensity"}) {
    auto* const field = head.add_fields();
    field->set_name(name);
    field->set_offset(offset);
    field->set_type(foxglove::PackedElementField::FLOAT32);
    offset += sizeof(float);
  }
  head.set_point_stride(offset);
  std::memcpy(cloud.writable().data(), scan.data(), scan.size_bytes());
}

}  // namespace hgros::bench::slam_run
