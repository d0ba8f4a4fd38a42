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

/// Applies a transform to x, y and z, and its rotation to normal_x, normal_y and normal_z where they are, all float or
/// all double. `out` has the size of the elements' data and either is that memory or has the same bytes. Returns what
/// is wrong with the fields, or nothing; then `out` is as it was.
[[nodiscard]] HGROS_EXPORT std::string TransformElements(const RigidTransform& T, const PackedElements& elements,
                                                         std::span<std::byte> out);

template <class T>
[[nodiscard]] RigidTransform PoseIn(const T& head) {
  if (!head.has_pose()) return {};
  const auto& at = head.pose().position();
  const auto& turn = head.pose().orientation();
  Eigen::Quaterniond rotation(turn.w(), turn.x(), turn.y(), turn.z());
  // An orientation that is not set is none.
  if (rotation.squaredNorm() < 1e-12) rotation.setIdentity();
  return {RigidTransform::Rotation(rotation.normalized()), Eigen::Vector3d(at.x(), at.y(), at.z())};
}

}  // namespace tf

/// Moves a cloud's points from its frame into another, in place; the cloud then is in `target_frame`, and its pose is
/// the identity. The cloud is one that nobody else has yet. Other fields of the points stay as they are. Errors:
/// returns what is wrong with the cloud, or nothing; then it is as it was.
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

/// The same into another cloud, which is as large: new, or lent by a session.
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
