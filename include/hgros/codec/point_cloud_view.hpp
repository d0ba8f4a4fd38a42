#pragma once

#include <utility>
#include <vector>

#include "hgros/codec/bulk.hpp"
#include "hgros/codec/packed_elements.hpp"

namespace hgros {

/// foxglove::PointCloud, and whatever has its fields.
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

/// The points of a cloud where they lie; x, y and z are in metres in the cloud's own coordinates (`pose` says where
/// those are in `frame_id`). The view borrows the message, which may be a Bulk.
///
///     const auto points = hgros::ViewPoints(cloud);
///     const auto x = points->Field<float>("x");        // each of the two: a view, or a fault()
///     for (const float metres : *x) ...
///
/// Errors: a stride of 0 or bytes that are no whole number of points; for a field: that there is none of the name, that
/// it is stored as another type, or that it lies outside its point.
template <PointCloudMessage T>
[[nodiscard]] ViewResult<PackedElements> ViewPoints(const T& cloud) {
  return codec::PointsIn(cloud, AsBytes(cloud.data()));
}
template <PointCloudMessage T>
[[nodiscard]] ViewResult<PackedElements> ViewPoints(const Bulk<T>& cloud) {
  return codec::PointsIn(cloud.head(), cloud.bytes());
}
/// Of a message that is about to end there is nothing to be seen.
template <class T>
void ViewPoints(const T&& cloud) = delete;

}  // namespace hgros
