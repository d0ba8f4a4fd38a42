#pragma once

#include "hgros/base/export.hpp"

namespace google::protobuf {
class Descriptor;
class FieldDescriptor;
}  // namespace google::protobuf

namespace hgros {

/// Which `bytes` field of the protobuf class T is the large one, for Bulk<T>. By default it is the only one that T has
/// at its top level. Specialise this, beside the schema's use and before the first use of Bulk<T>, where T has several:
///
///     template <>
///     struct hgros::BulkField<my::Scan> {
///       static constexpr int kNumber = my::Scan::kRangesFieldNumber;
///     };
template <class T>
struct BulkField {
  static constexpr int kNumber = 0;  ///< 0: the only one.
};

namespace codec {

/// The field of `number`, or for 0 the only one that can be the large one: singular, of type bytes, at the top level,
/// not required and in no oneof. Errors: throws Error if there is no such field, or if for 0 there are several; it
/// names the type, the candidates and the mend.
[[nodiscard]] HGROS_EXPORT const google::protobuf::FieldDescriptor& FindBulkField(
    const google::protobuf::Descriptor& type, int number);

}  // namespace codec
}  // namespace hgros
