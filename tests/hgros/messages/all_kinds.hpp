#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "hgros/codec/dynamic_schema.hpp"
#include "hgros/proto_folder.hpp"
#include "messages/type_finder.hpp"

namespace hgros::cli {

/// A type as it is read from its description.
inline std::shared_ptr<const DynamicSchema> Dynamic(const google::protobuf::Descriptor& type) {
  std::string fault;
  auto schema = DynamicSchema::Build(SchemaFor(type), fault);
  EXPECT_NE(schema, nullptr) << fault;
  return schema;
}

/// Finds kinds.All, a type with fields of every kind.
struct AllKinds {
  ProtoFolder folder;
  TypeFinder finder{TypeOptions{{folder.Write("all.proto", R"(syntax = "proto3";
package kinds;
import "google/protobuf/timestamp.proto";
import "google/protobuf/duration.proto";
import "foxglove/Pose.proto";

enum Color { RED = 0; GREEN = 1; }
enum Switch { OFF = 0; ON = 1; HALF = 2; }
message All {
  message Part { double x = 1; repeated Part parts = 2; }
  double a_double = 1;
  float a_float = 2;
  int32 a_int32 = 3;
  int64 a_int64 = 4;
  uint32 a_uint32 = 5;
  uint64 a_uint64 = 6;
  sint64 a_sint64 = 7;
  fixed32 a_fixed32 = 8;
  sfixed64 a_sfixed64 = 9;
  bool a_bool = 10;
  string a_string = 11;
  bytes a_bytes = 12;
  Color a_color = 13;
  optional Switch a_switch = 14;
  repeated float floats = 20;
  repeated string texts = 21;
  repeated bytes blocks = 22;
  repeated Color colors = 23;
  repeated bool bools = 24;
  repeated Part several = 25;
  google.protobuf.Timestamp time = 30;
  google.protobuf.Duration duration = 31;
  repeated google.protobuf.Duration durations = 32;
  map<string, int32> labels = 40;
  map<uint32, Part> parts = 41;
  oneof choice { int32 chosen_number = 50; string chosen_text = 51; Part chosen_part = 52; }
  optional double maybe = 60;
  foxglove.Pose pose = 70;
}
)")},
                                {}}};
};

}  // namespace hgros::cli
