#pragma once

#include <string>

#include "messages/message_document.hpp"

namespace google::protobuf {
class FieldDescriptor;
class Message;
}  // namespace google::protobuf

namespace hgros::cli {

/// Sets the fields of `message`, which is empty, from a value of `document`: what `hgros echo --full` shows as YAML or
/// JSON. Also accepted: numbers of enums, maps as YAML maps, "now" and seconds as time, numbers in hexadecimal. A null
/// leaves its field unset.
///
/// Throws ConfigError with the position of what does not fit, and the nearest name.
void ReadMessage(const MessageDocument& document, const yaml::Node& value, google::protobuf::Message& message);
inline void ReadMessage(const MessageDocument& document, google::protobuf::Message& message) {
  ReadMessage(document, document.root(), message);
}

/// Whether the field is a map. The schema of a publisher has lists of entries in their place.
[[nodiscard]] bool IsMapField(const google::protobuf::FieldDescriptor& field);

}  // namespace hgros::cli
