#pragma once

#include "hgros/base/export.hpp"

namespace google::protobuf {
class Descriptor;
class FieldDescriptor;
}  // namespace google::protobuf

namespace hgros {

/// The large `bytes` field of the protobuf class T for Bulk<T>. By default the only one at the top level of T. If T has
/// several, specialize this before the first use of Bulk<T>:
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

/// The field `number`, or for 0 the only field that can be the large one: singular, of type bytes, at the top level,
/// not required and in no oneof. Errors: throws Error if there is no such field, or several for 0; it names the type,
/// the candidates and the fix.
[[nodiscard]] HGROS_EXPORT const google::protobuf::FieldDescriptor& FindBulkField(
    const google::protobuf::Descriptor& type, int number);

}  // namespace codec
}  // namespace hgros
