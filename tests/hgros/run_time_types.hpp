#pragma once

#include <google/protobuf/descriptor.pb.h>

#include <cstring>
#include <string>
#include <tuple>

#include "hgros/codec/raw_message.hpp"

namespace hgros::cli {

/// A protobuf type that no program is compiled with: message robot.Grip { double width = 1; string name = 2; }.
[[nodiscard]] inline MessageSchema GripSchema() {
  using google::protobuf::FieldDescriptorProto;
  google::protobuf::FileDescriptorSet set;
  auto& file = *set.add_file();
  file.set_name("robot/grip.proto");
  file.set_package("robot");
  file.set_syntax("proto3");
  auto& type = *file.add_message_type();
  type.set_name("Grip");
  for (const auto& [name, number, kind] :
       {std::tuple{"width", 1, FieldDescriptorProto::TYPE_DOUBLE}, {"name", 2, FieldDescriptorProto::TYPE_STRING}}) {
    auto& field = *type.add_field();
    field.set_name(name);
    field.set_number(number);
    field.set_type(kind);
    field.set_label(FieldDescriptorProto::LABEL_OPTIONAL);
  }
  return {"robot.Grip", Encoding::kProtobuf, 0, set.SerializeAsString()};
}

/// One message of it: tag, then eight bytes; tag, length, text. docs: protobuf.dev/programming-guides/encoding
[[nodiscard]] inline std::string GripBytes(double width, const std::string& name) {
  std::string bytes(9, '\x09');
  std::memcpy(bytes.data() + 1, &width, sizeof width);
  return bytes + '\x12' + static_cast<char>(name.size()) + name;
}

}  // namespace hgros::cli
