#include "viewer/e2e/message_parts.hpp"

namespace hgros::viewer::test {

void SetStamp(google::protobuf::Timestamp& stamp, std::int64_t ns) {
  stamp.set_seconds(ns / 1'000'000'000);
  stamp.set_nanos(static_cast<std::int32_t>(ns % 1'000'000'000));
}

void SetPose(foxglove::Pose& pose, const RigidTransform& T_frame_pose) {
  const Eigen::Vector3d& position = T_frame_pose.translation;
  const RigidTransform::Rotation& rotation = T_frame_pose.rotation;
  pose.mutable_position()->set_x(position.x());
  pose.mutable_position()->set_y(position.y());
  pose.mutable_position()->set_z(position.z());
  pose.mutable_orientation()->set_x(rotation.x());
  pose.mutable_orientation()->set_y(rotation.y());
  pose.mutable_orientation()->set_z(rotation.z());
  pose.mutable_orientation()->set_w(rotation.w());
}

void SetFloatFields(foxglove::PointCloud& cloud) {
  std::uint32_t offset = 0;
  for (const char* name : {"x", "y", "z", "intensity"}) {
    auto* const field = cloud.add_fields();
    field->set_name(name);
    field->set_offset(offset);
    field->set_type(foxglove::PackedElementField::FLOAT32);
    offset += 4;
  }
  cloud.set_point_stride(offset);
}

}  // namespace hgros::viewer::test
