#pragma once

#include <cstdint>

#include "foxglove/PointCloud.pb.h"
#include "foxglove/Pose.pb.h"
#include "google/protobuf/timestamp.pb.h"
#include "hgros/tf/rigid_transform.hpp"

namespace hgros::viewer::test {

void SetStamp(google::protobuf::Timestamp& stamp, std::int64_t ns);
/// A foxglove::Vector3 or Point3.
template <class Vector>
void SetXyz(Vector& vector, double x, double y, double z) {
  vector.set_x(x);
  vector.set_y(y);
  vector.set_z(z);
}
void SetPose(foxglove::Pose& pose, const RigidTransform& T_frame_pose);
/// x, y, z and intensity, 4 bytes each.
void SetFloatFields(foxglove::PointCloud& cloud);

}  // namespace hgros::viewer::test
