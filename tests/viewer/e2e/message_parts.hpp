#pragma once

#include <cstdint>
#include <string>

#include "foxglove/PointCloud.pb.h"
#include "foxglove/SceneUpdate.pb.h"
#include "hgros/tf/rigid_transform.hpp"

namespace hgros::viewer::test {

inline void SetStamp(google::protobuf::Timestamp& stamp, std::int64_t ns) {
  stamp.set_seconds(ns / 1'000'000'000);
  stamp.set_nanos(static_cast<std::int32_t>(ns % 1'000'000'000));
}
template <class Vector>
void SetXy(Vector& vector, double x, double y) {
  vector.set_x(x);
  vector.set_y(y);
}
/// A foxglove::Vector3 or Point3.
template <class Vector>
void SetXyz(Vector& vector, double x, double y, double z) {
  SetXy(vector, x, y);
  vector.set_z(z);
}
inline void SetColor(foxglove::Color& color, double r, double g, double b, double a = 1) {
  color.set_r(r);
  color.set_g(g);
  color.set_b(b);
  color.set_a(a);
}
inline void SetPose(foxglove::Pose& pose, const RigidTransform& T_frame_pose) {
  const Eigen::Vector3d& at = T_frame_pose.translation;
  SetXyz(*pose.mutable_position(), at.x(), at.y(), at.z());
  SetXyz(*pose.mutable_orientation(), T_frame_pose.rotation.x(), T_frame_pose.rotation.y(), T_frame_pose.rotation.z());
  pose.mutable_orientation()->set_w(T_frame_pose.rotation.w());
}

/// To a cloud, a grid or voxels.
template <class Message>
void AddField(Message& message, const std::string& name, foxglove::PackedElementField::NumericType type,
              std::uint32_t offset = 0) {
  auto& field = *message.add_fields();
  field.set_name(name);
  field.set_type(type);
  field.set_offset(offset);
}
/// Behind the other fields of each point.
inline void AddPointField(foxglove::PointCloud& cloud, const std::string& name,
                          foxglove::PackedElementField::NumericType type, std::uint32_t bytes) {
  AddField(cloud, name, type, cloud.point_stride());
  cloud.set_point_stride(cloud.point_stride() + bytes);
}
/// x, y, z and intensity, 4 bytes each.
inline void SetFloatFields(foxglove::PointCloud& cloud) {
  for (const char* name : {"x", "y", "z", "intensity"}) {
    AddPointField(cloud, name, foxglove::PackedElementField::FLOAT32, 4);
  }
}

/// Cells without padding, to a grid or voxels.
template <class Cells>
void SetCells(Cells& cells, std::uint32_t columns, std::uint32_t bytes, double edge) {
  cells.set_column_count(columns);
  cells.set_cell_stride(bytes);
  cells.set_row_stride(columns * bytes);
  SetXy(*cells.mutable_cell_size(), edge, edge);
}
template <class Voxels>
void SetVoxels(Voxels& voxels, std::uint32_t columns, std::uint32_t rows, std::uint32_t bytes, double edge) {
  SetCells(voxels, columns, bytes, edge);
  voxels.set_row_count(rows);
  voxels.set_slice_stride(columns * rows * bytes);
  voxels.mutable_cell_size()->set_z(edge);
}

inline foxglove::SceneEntity& AddEntity(foxglove::SceneUpdate& update, const std::string& id,
                                        const std::string& frame = "map") {
  foxglove::SceneEntity& entity = *update.add_entities();
  entity.set_id(id);
  entity.set_frame_id(frame);
  return entity;
}
/// A cube, sphere or cylinder.
template <class Solid>
void SetSolid(Solid& solid, const Eigen::Vector3d& at, const Eigen::Vector3d& size, const Eigen::Vector4d& rgba) {
  SetXyz(*solid.mutable_pose()->mutable_position(), at.x(), at.y(), at.z());
  SetXyz(*solid.mutable_size(), size.x(), size.y(), size.z());
  SetColor(*solid.mutable_color(), rgba[0], rgba[1], rgba[2], rgba[3]);
}
inline void AddCube(foxglove::SceneEntity& entity, const Eigen::Vector3d& at, double edge, double alpha = 1) {
  SetSolid(*entity.add_cubes(), at, Eigen::Vector3d::Constant(edge), {0.9, 0.5, 0.1, alpha});
}

}  // namespace hgros::viewer::test
