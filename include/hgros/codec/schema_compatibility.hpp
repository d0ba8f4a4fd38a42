#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/export.hpp"

namespace google::protobuf {
class Descriptor;
}

namespace hgros {

/// Whether what they write can be read as what we know.
struct SchemaVerdict {
  bool compatible = false;
  std::string reason;  ///< Why not: names the message, the field number and both fields. Empty if compatible.
  std::vector<std::string> notes;  ///< What is odd but readable, such as a number whose field has another name here.
};

/// Compares a peer's schema with ours by the protobuf language guide's rules on updating a message type: every field
/// number that both know, in the message and in all messages reachable through such fields, must be of one wire
/// family and both singular or both repeated. Numbers that only one side knows are no obstacle, except a field that
/// is `required` here.
///
/// Families: int32, uint32, int64, uint64, bool and enums; sint32 and sint64; fixed32 and sfixed32; fixed64 and
/// sfixed64; string and bytes; float, double, message and group each alone.
///
/// `their_descriptor_set` comes from the network: anything may be in it. It is refused (not compatible, with the
/// reason) if it is larger than 1 MiB, does not parse, or lacks a file or the type; and if it has more than 256 files,
/// 10,000 types, fields, enum values and imports in all, 32 levels of nested types, or 512 bytes in a full name.
/// Nothing is logged.
///
/// Threading: thread-safe. Takes from 0.1 ms up: once per peer and channel, never per message.
[[nodiscard]] HGROS_EXPORT SchemaVerdict CheckSchemas(std::string_view their_descriptor_set,
                                                      const std::string& their_type_name,
                                                      const google::protobuf::Descriptor& ours);

}  // namespace hgros
