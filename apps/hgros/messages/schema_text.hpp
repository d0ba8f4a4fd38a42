#pragma once

#include <string>
#include <vector>

namespace google::protobuf {
class Descriptor;
class FieldDescriptor;
}  // namespace google::protobuf

namespace hgros::cli {

/// The type and all types that it contains, as in .proto files. The type itself is the last.
[[nodiscard]] std::string ProtoText(const google::protobuf::Descriptor& type);

/// A message of the type as YAML, with each field and an example of its value. `hgros pub` accepts it. A type that
/// contains itself is written once.
[[nodiscard]] std::string TemplateText(const google::protobuf::Descriptor& type);

/// The fields of the type and of all messages in it, by type in the order of ProtoText().
[[nodiscard]] std::vector<const google::protobuf::FieldDescriptor*> FieldsOf(const google::protobuf::Descriptor& type);

/// "double", "map<string, int32>", or the full name of a message or an enum.
[[nodiscard]] std::string KindOf(const google::protobuf::FieldDescriptor& field);

}  // namespace hgros::cli
