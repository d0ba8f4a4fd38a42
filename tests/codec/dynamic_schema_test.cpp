#include "hgros/codec/dynamic_schema.hpp"

#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/dynamic_message.h>
#include <google/protobuf/message.h>
#include <gtest/gtest.h>

#include "codec/parsed_memory.hpp"
#include "foxglove/CameraCalibration.pb.h"
#include "foxglove/Log.pb.h"
#include "foxglove/PointCloud.pb.h"
#include "hgros/codec/message.hpp"

namespace hgros::dynamic_schema_test {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::FileDescriptorSet;
using ::testing::HasSubstr;

MessageSchema SchemaWith(const FileDescriptorSet& set, const std::string& type) {
  return {type, Encoding::kProtobuf, 1, set.SerializeAsString()};
}

std::string FaultOf(const MessageSchema& schema) {
  std::string fault;
  EXPECT_EQ(DynamicSchema::Build(schema, fault), nullptr);
  return fault;
}

TEST(DynamicSchema, ReadsMessagesOfATypeWithImports) {
  std::string fault;
  const auto schema = DynamicSchema::Build(SchemaOf(TypeOf<foxglove::PointCloud>()), fault);
  ASSERT_NE(schema, nullptr) << fault;
  foxglove::PointCloud cloud;
  cloud.set_frame_id("lidar");
  cloud.mutable_pose()->mutable_position()->set_x(4);
  const auto message = schema->Read(AsBytes(cloud.SerializeAsString()));
  ASSERT_NE(message, nullptr);
  const auto& type = schema->descriptor();
  EXPECT_EQ(message->GetReflection()->GetString(*message, type.FindFieldByName("frame_id")), "lidar");
  const auto& pose = message->GetReflection()->GetMessage(*message, type.FindFieldByName("pose"));
  const auto& position = pose.GetReflection()->GetMessage(pose, pose.GetDescriptor()->FindFieldByName("position"));
  EXPECT_EQ(position.GetReflection()->GetDouble(position, position.GetDescriptor()->FindFieldByName("x")), 4);
  EXPECT_EQ(message->SerializeAsString(), cloud.SerializeAsString());
}

TEST(DynamicSchema, RefusesAMessageThatTakesMuchMoreMemoryThanItsSize) {
  std::string fault;
  const auto schema = DynamicSchema::Build(SchemaOf(TypeOf<foxglove::PointCloud>()), fault);
  ASSERT_NE(schema, nullptr) << fault;
  foxglove::PointCloud one;
  one.add_fields();
  const std::string field = one.SerializeAsString();
  std::string hostile;
  while (hostile.size() < (8 << 20)) hostile += field;  // 4 million empty fields.
  EXPECT_EQ(schema->Read(AsBytes(hostile)), nullptr);
  EXPECT_NE(schema->Read(AsBytes(hostile).first(1 << 20)), nullptr);
  EXPECT_EQ(schema->Read(AsBytes(hostile).first(1 << 20), 1 << 20), nullptr);
  EXPECT_EQ(schema->Read(AsBytes(hostile).first(1 << 20), fault, 1 << 20), nullptr);
  EXPECT_EQ(fault, "Its 1048576 bytes are estimated to take more than 1048576 bytes of memory beyond their own size.");
  std::string unknown;
  while (unknown.size() < (32 << 20)) unknown += "\x78\x01";  // Field 15.
  EXPECT_EQ(schema->Read(AsBytes(unknown)), nullptr);
  foxglove::PointCloud large;
  large.mutable_data()->resize(64 << 20);
  EXPECT_NE(schema->Read(AsBytes(large.SerializeAsString()), 1 << 20), nullptr) << "its bytes do not count";
}

TEST(DynamicSchema, ReadsLargeArraysOfFixedSizeNumbers) {
  std::string fault;
  const auto schema = DynamicSchema::Build(SchemaOf(TypeOf<foxglove::CameraCalibration>()), fault);
  ASSERT_NE(schema, nullptr) << fault;
  foxglove::CameraCalibration calibration;
  calibration.mutable_d()->Resize(1 << 20, 1);  // 8 MiB.
  const std::string bytes = calibration.SerializeAsString();
  EXPECT_NE(schema->Read(AsBytes(bytes), 24 << 20), nullptr);
  EXPECT_EQ(schema->Read(AsBytes(bytes), 8 << 20), nullptr);
}

TEST(ParsedMemory, IsNotLessThanWhatProtobufReports) {
  google::protobuf::DynamicMessageFactory factory;
  const auto& type = *google::protobuf::FileDescriptorProto::descriptor();
  const ParsedMemory memory(type, factory);
  google::protobuf::FileDescriptorSet set;
  ASSERT_TRUE(set.ParseFromString(SchemaOf(TypeOf<foxglove::PointCloud>()).descriptor_set));
  for (const auto& file : set.file()) {
    const std::string bytes = file.SerializeAsString();
    std::unique_ptr<google::protobuf::Message> parsed(factory.GetPrototype(&type)->New());
    ASSERT_TRUE(parsed->ParseFromString(bytes));
    const std::size_t used = parsed->SpaceUsedLong();
    ASSERT_GT(used, bytes.size());
    EXPECT_FALSE(memory.Fits(AsBytes(bytes), used - bytes.size() - 1)) << file.name();
    EXPECT_TRUE(memory.Fits(AsBytes(bytes), 8 * used)) << file.name();
    EXPECT_TRUE(memory.Fits(AsBytes(bytes).first(bytes.size() / 2), 8 * used)) << "a broken one";
  }
}

TEST(DynamicSchema, HasTheNamesOfEnumValues) {
  std::string fault;
  const auto schema = DynamicSchema::Build(SchemaOf(TypeOf<foxglove::Log>()), fault);
  ASSERT_NE(schema, nullptr) << fault;
  EXPECT_EQ(schema->descriptor().FindFieldByName("level")->enum_type()->FindValueByNumber(4)->name(), "ERROR");
}

TEST(MisfitOf, TrustsAPublisherWithoutADescription) {
  MessageSchema theirs = SchemaOf(TypeOf<foxglove::Log>());
  ++theirs.fingerprint;
  theirs.descriptor_set.clear();
  EXPECT_EQ(MisfitOf(theirs, TypeOf<foxglove::Log>()), "");
  theirs.type_name = "foxglove.Logs";
  EXPECT_THAT(MisfitOf(theirs, TypeOf<foxglove::Log>()), HasSubstr("foxglove.Logs there"));
}

TEST(DynamicSchema, ReadsAnEnumWithTwoNamesForOneValue) {
  google::protobuf::FileDescriptorSet set;
  auto& file = *set.add_file();
  file.set_name("gear.proto");
  file.set_syntax("proto3");
  auto& gear = *file.add_enum_type();
  gear.set_name("Gear");
  gear.mutable_options()->set_allow_alias(true);
  for (const char* name : {"NEUTRAL", "IDLE"}) {
    gear.add_value()->set_name(name);
    gear.mutable_value(gear.value_size() - 1)->set_number(0);
  }
  auto& type = *file.add_message_type();
  type.set_name("Drive");
  auto& field = *type.add_field();
  field.set_name("gear");
  field.set_number(1);
  field.set_label(google::protobuf::FieldDescriptorProto::LABEL_OPTIONAL);
  field.set_type(google::protobuf::FieldDescriptorProto::TYPE_ENUM);
  field.set_type_name(".Gear");
  std::string fault;
  EXPECT_NE(DynamicSchema::Build({"Drive", Encoding::kProtobuf, 1, set.SerializeAsString()}, fault), nullptr) << fault;
}

TEST(DynamicSchema, RefusesBytesThatDoNotParse) {
  std::string fault;
  const auto schema = DynamicSchema::Build(SchemaOf(TypeOf<foxglove::Log>()), fault);
  EXPECT_EQ(schema->Read(AsBytes("\xff\xff\xff"), fault), nullptr);
  EXPECT_EQ(fault, "Its bytes do not parse.");
  EXPECT_NE(schema->Read({}), nullptr);
}

TEST(DynamicSchema, ReportsWhyADescriptionIsInvalid) {
  EXPECT_THAT(FaultOf({"t.M", Encoding::kPlain, 0, ""}), HasSubstr("t.M are not protobuf"));
  EXPECT_THAT(FaultOf({"t.M", Encoding::kProtobuf, 0, "\xff\xff"}), HasSubstr("is not a FileDescriptorSet"));
  EXPECT_THAT(FaultOf({"t.M", Encoding::kProtobuf, 0, ""}), HasSubstr("does not contain t.M"));
  EXPECT_THAT(FaultOf({"t.M", Encoding::kProtobuf, 0, std::string((1 << 20) + 1, 'x')}), HasSubstr("more than"));

  FileDescriptorSet lacks;
  lacks.add_file()->set_name("a.proto");
  lacks.mutable_file(0)->add_dependency("missing.proto");
  EXPECT_THAT(FaultOf(SchemaWith(lacks, "t.M")), HasSubstr("is not valid: a.proto: missing.proto"));
  lacks.mutable_file(0)->set_dependency(0, "a.proto");
  EXPECT_THAT(FaultOf(SchemaWith(lacks, "t.M")), HasSubstr("is not valid: a.proto imports itself."));

  FileDescriptorSet deep;
  deep.add_file()->set_name("a.proto");
  auto* type = deep.mutable_file(0)->add_message_type();
  for (int i = 0; i < 40; ++i) {
    type->set_name("M");
    type = type->add_nested_type();
  }
  type->set_name("M");
  EXPECT_THAT(FaultOf(SchemaWith(deep, "M")), HasSubstr("levels of nested types"));
}

TEST(DynamicSchema, ReadsRecursiveTypesAsDeepAsProtobufAllows) {
  FileDescriptorSet set;
  auto& file = *set.add_file();
  file.set_name("a.proto");
  file.set_syntax("proto3");
  auto& type = *file.add_message_type();
  type.set_name("M");
  auto& field = *type.add_field();
  field.set_name("m");
  field.set_number(1);
  field.set_label(google::protobuf::FieldDescriptorProto::LABEL_OPTIONAL);
  field.set_type(google::protobuf::FieldDescriptorProto::TYPE_MESSAGE);
  field.set_type_name(".M");
  std::string fault;
  const auto schema = DynamicSchema::Build(SchemaWith(set, "M"), fault);
  ASSERT_NE(schema, nullptr) << fault;
  EXPECT_NE(schema->Read(AsBytes(std::string("\x0a\x02\x0a\x00", 4))), nullptr);
  std::string deep;
  for (int i = 0; i < 20000; ++i) deep += "\x0b";  // Groups that never end.
  EXPECT_EQ(schema->Read(AsBytes(deep)), nullptr);
}

}  // namespace
}  // namespace hgros::dynamic_schema_test
