#pragma once

#include <cstddef>
#include <cstring>
#include <span>
#include <string>
#include <string_view>

#include "hgros/base/export.hpp"
#include "hgros/codec/bulk.hpp"
#include "hgros/codec/packed_elements.hpp"
#include "hgros/codec/point_cloud_view.hpp"
#include "hgros/tf/rigid_transform.hpp"

namespace hgros {
namespace tf {

/// Applies a transform to x, y and z, and its rotation to normal_x, normal_y and normal_z if present; all float or all
/// double. `out` has the size of the elements' data and is either the same memory or a copy of it. Returns what is
/// wrong with the fields, or an empty text; on an error `out` is unchanged.
[[nodiscard]] HGROS_EXPORT std::string TransformElements(const RigidTransform& T, const PackedElements& elements,
                                                         std::span<std::byte> out);

template <class T>
[[nodiscard]] RigidTransform PoseIn(const T& head) {
  if (!head.has_pose()) return {};
  const auto& at = head.pose().position();
  const auto& turn = head.pose().orientation();
  Eigen::Quaterniond rotation(turn.w(), turn.x(), turn.y(), turn.z());
  // An unset orientation is the identity.
  if (rotation.squaredNorm() < 1e-12) rotation.setIdentity();
  return {RigidTransform::Rotation(rotation.normalized()), Eigen::Vector3d(at.x(), at.y(), at.z())};
}

}  // namespace tf

/// Moves the points of a cloud into another frame, in place. Afterwards the cloud is in `target_frame` and its pose is
/// the identity; other fields of the points keep their values. The caller must be the only user of the cloud.
/// Errors: returns what is wrong with the cloud, or an empty text; on an error the cloud is unchanged.
template <PointCloudMessage T>
[[nodiscard]] std::string TransformCloud(const RigidTransform& T_target_source, std::string_view target_frame,
                                         Bulk<T>& cloud) {
  const auto points = ViewPoints(cloud);
  if (!points) return points.fault();
  if (cloud.writable().size() != cloud.bytes().size())
    return "The cloud's bytes are shared with others; transform a copy.";
  std::string fault = tf::TransformElements(T_target_source * tf::PoseIn(cloud.head()), *points, cloud.writable());
  if (!fault.empty()) return fault;
  cloud.head().set_frame_id(std::string(target_frame));
  cloud.head().clear_pose();
  return {};
}

/// The same into another cloud of the same size: a new one, or a loan of a session.
template <PointCloudMessage T>
[[nodiscard]] std::string TransformCloud(const RigidTransform& T_target_source, std::string_view target_frame,
                                         const Bulk<T>& cloud, Bulk<T>& out) {
  const Bytes bytes = cloud.bytes();
  if (out.writable().size() != bytes.size()) return "The cloud to write has not the size of the one to read.";
  T head = cloud.head();
  head.clear_data();
  out.head() = std::move(head);
  if (!bytes.empty()) std::memcpy(out.writable().data(), bytes.data(), bytes.size());
  return TransformCloud(T_target_source, target_frame, out);
}

}  // namespace hgros
