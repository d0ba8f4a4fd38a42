#pragma once

#include <utility>
#include <vector>

#include "hgros/codec/bulk.hpp"
#include "hgros/codec/packed_elements.hpp"

namespace hgros {

/// foxglove::PointCloud, or any type with its fields.
template <class T>
concept PointCloudMessage = ProtobufMessage<T> && requires(const T& cloud) {
  cloud.point_stride();
  cloud.fields().begin()->name();
  cloud.fields().begin()->offset();
  cloud.fields().begin()->type();
  cloud.data();
};

namespace codec {

template <PointCloudMessage T>
[[nodiscard]] ViewResult<PackedElements> PointsIn(const T& head, Bytes data) {
  std::vector<ElementField> fields;
  for (const auto& field : head.fields()) {
    fields.push_back({field.name(), field.offset(), static_cast<int>(field.type())});
  }
  return PackedElements::Of(data, head.point_stride(), std::move(fields));
}

}  // namespace codec

/// The points of a cloud in place; x, y and z are in meters in the cloud's own coordinates, whose `pose` is given in
/// `frame_id`. The view borrows the message, which may be a Bulk.
///
///     const auto points = hgros::ViewPoints(cloud);
///     const auto x = points->Field<float>("x");        // each of the two: a view, or a fault()
///     for (const float x_m : *x) ...
///
/// Errors: a stride of 0 or a partial point at the end. For a field: it does not exist, it is stored as another type,
/// or it is outside its point.
template <PointCloudMessage T>
[[nodiscard]] ViewResult<PackedElements> ViewPoints(const T& cloud) {
  return codec::PointsIn(cloud, AsBytes(cloud.data()));
}
template <PointCloudMessage T>
[[nodiscard]] ViewResult<PackedElements> ViewPoints(const Bulk<T>& cloud) {
  return codec::PointsIn(cloud.head(), cloud.bytes());
}
/// Deleted: a view of a temporary message would dangle.
template <class T>
void ViewPoints(const T&& cloud) = delete;

}  // namespace hgros
