#include "tf/transform_messages.hpp"

namespace hgros::tf {

void Append(foxglove::FrameTransforms& message, std::string_view parent, std::string_view child, Time stamp,
            const RigidTransform& T_parent_child) {
  foxglove::FrameTransform& one = *message.add_transforms();
  std::int64_t seconds = stamp.nanoseconds / kNanosPerSecond;
  std::int64_t nanos = stamp.nanoseconds % kNanosPerSecond;
  if (nanos < 0) {  // The nanoseconds of a protobuf time are never negative, even before 1970.
    --seconds;
    nanos += kNanosPerSecond;
  }
  one.mutable_timestamp()->set_seconds(seconds);
  one.mutable_timestamp()->set_nanos(static_cast<std::int32_t>(nanos));
  one.set_parent_frame_id(parent.data(), parent.size());
  one.set_child_frame_id(child.data(), child.size());
  one.mutable_translation()->set_x(T_parent_child.translation.x());
  one.mutable_translation()->set_y(T_parent_child.translation.y());
  one.mutable_translation()->set_z(T_parent_child.translation.z());
  one.mutable_rotation()->set_x(T_parent_child.rotation.x());
  one.mutable_rotation()->set_y(T_parent_child.rotation.y());
  one.mutable_rotation()->set_z(T_parent_child.rotation.z());
  one.mutable_rotation()->set_w(T_parent_child.rotation.w());
}

std::optional<Time> StampOf(const foxglove::FrameTransform& message) {
  return TimeOf(message.timestamp().seconds(), message.timestamp().nanos());
}

RigidTransform TransformOf(const foxglove::FrameTransform& message) {
  RigidTransform T;
  T.translation = {message.translation().x(), message.translation().y(), message.translation().z()};
  if (message.has_rotation()) {
    T.rotation = {message.rotation().w(), message.rotation().x(), message.rotation().y(), message.rotation().z()};
  }
  return T;
}

}  // namespace hgros::tf
