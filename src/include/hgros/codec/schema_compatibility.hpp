#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/export.hpp"

namespace google::protobuf {
class Descriptor;
}

namespace hgros {

/// Whether messages of another schema can be read with ours.
struct SchemaVerdict {
  bool compatible = false;
  std::string reason;  ///< The message, the field number and both fields that differ. Empty if compatible.
  std::vector<std::string>
      notes;  ///< Oddities that do not prevent reading, such as a field number with another name here.
};

/// Compares a peer's schema with ours by the protobuf language guide's rules on updating a message type. Every field
/// number that both sides know, in the message and in all messages reachable through such fields, must be of one wire
/// family and either singular or repeated on both sides. A number known to one side only is accepted, unless the field
/// is `required` here.
///
/// Families: int32, uint32, int64, uint64, bool and enums; sint32 and sint64; fixed32 and sfixed32; fixed64 and
/// sfixed64; string and bytes; float, double, message and group each alone.
///
/// `their_descriptor_set` comes from the network and may contain anything. It is refused (not compatible, with the
/// reason) if it is larger than 1 MiB, does not parse, or lacks a file or the type, and beyond 256 files, 10,000 types,
/// fields, enum values and imports in total, 32 levels of nested types, or 512 bytes in a full name. Nothing is logged.
///
/// Threading: thread-safe. Takes 0.1 ms or more: call it once per peer and channel, not per message.
[[nodiscard]] HGROS_EXPORT SchemaVerdict CheckSchemas(std::string_view their_descriptor_set,
                                                      const std::string& their_type_name,
                                                      const google::protobuf::Descriptor& ours);

}  // namespace hgros
