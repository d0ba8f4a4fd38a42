#include "hgros/codec/dynamic_schema.hpp"

#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/dynamic_message.h>
#include <google/protobuf/message.h>
#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include "codec/parsed_memory.hpp"
#include "foxglove/CameraCalibration.pb.h"
#include "foxglove/Log.pb.h"
#include "foxglove/PointCloud.pb.h"
#include "hgros/codec/message.hpp"

namespace hgros::dynamic_schema_test {
namespace {

using google::protobuf::FileDescriptorSet;
using ::testing::HasSubstr;

MessageSchema SchemaWith(const FileDescriptorSet& set, const std::string& type) {
  return {type, Encoding::kProtobuf, 1, set.SerializeAsString()};
}

std::shared_ptr<const DynamicSchema> Built(const MessageSchema& schema) {
  std::string fault;
  auto built = DynamicSchema::Build(schema, fault);
  EXPECT_NE(built, nullptr) << fault;
  return built;
}

/// A file without imports, in the text form of descriptors.
MessageSchema SchemaWith(const std::string& file, const std::string& type) {
  FileDescriptorSet set;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(file, set.add_file())) << file;
  return SchemaWith(set, type);
}

std::string FaultOf(const MessageSchema& schema) {
  std::string fault;
  EXPECT_EQ(DynamicSchema::Build(schema, fault), nullptr);
  return fault;
}

TEST(DynamicSchema, ReadsMessagesOfATypeWithImports) {
  const auto schema = Built(SchemaOf(TypeOf<foxglove::PointCloud>()));
  ASSERT_NE(schema, nullptr);
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
  const auto schema = Built(SchemaOf(TypeOf<foxglove::PointCloud>()));
  ASSERT_NE(schema, nullptr);
  foxglove::PointCloud one;
  one.add_fields();
  std::string hostile = one.SerializeAsString();
  while (hostile.size() < (8 << 20)) hostile += hostile;  // 4 million empty fields.
  EXPECT_EQ(schema->Read(AsBytes(hostile)), nullptr);
  EXPECT_NE(schema->Read(AsBytes(hostile).first(1 << 20)), nullptr);
  EXPECT_EQ(schema->Read(AsBytes(hostile).first(1 << 20), 1 << 20), nullptr);
  std::string fault;
  EXPECT_EQ(schema->Read(AsBytes(hostile).first(1 << 20), fault, 1 << 20), nullptr);
  EXPECT_EQ(fault, "Its 1048576 bytes are estimated to take more than 1048576 bytes of memory beyond their own size.");
  std::string unknown = "\x78\x01";  // Field 15.
  while (unknown.size() < (32 << 20)) unknown += unknown;
  EXPECT_EQ(schema->Read(AsBytes(unknown)), nullptr);
  foxglove::PointCloud large;
  large.mutable_data()->resize(64 << 20);
  EXPECT_NE(schema->Read(AsBytes(large.SerializeAsString()), 1 << 20), nullptr) << "its bytes do not count";
}

TEST(DynamicSchema, ReadsLargeArraysOfFixedSizeNumbers) {
  const auto schema = Built(SchemaOf(TypeOf<foxglove::CameraCalibration>()));
  ASSERT_NE(schema, nullptr);
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
  FileDescriptorSet set;
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

TEST(MisfitOf, TrustsAPublisherWithoutADescription) {
  MessageSchema theirs = SchemaOf(TypeOf<foxglove::Log>());
  ++theirs.fingerprint;
  theirs.descriptor_set.clear();
  EXPECT_EQ(MisfitOf(theirs, TypeOf<foxglove::Log>()), "");
  theirs.type_name = "foxglove.Logs";
  EXPECT_THAT(MisfitOf(theirs, TypeOf<foxglove::Log>()), HasSubstr("foxglove.Logs there"));
}

TEST(DynamicSchema, ReadsAnEnumWithTwoNamesForOneValue) {
  (void)Built(
      SchemaWith("name: 'gear.proto' syntax: 'proto3' enum_type { name: 'Gear' options { allow_alias: true } "
                 "value { name: 'NEUTRAL' number: 0 } value { name: 'IDLE' number: 0 } } "
                 "message_type { name: 'Drive' field { name: 'gear' number: 1 label: LABEL_OPTIONAL "
                 "type: TYPE_ENUM type_name: '.Gear' } }",
                 "Drive"));
}

TEST(DynamicSchema, HasTheNamesOfEnumValuesAndRefusesBytesThatDoNotParse) {
  const auto schema = Built(SchemaOf(TypeOf<foxglove::Log>()));
  ASSERT_NE(schema, nullptr);
  EXPECT_EQ(schema->descriptor().FindFieldByName("level")->enum_type()->FindValueByNumber(4)->name(), "ERROR");
  std::string fault;
  EXPECT_EQ(schema->Read(AsBytes("\xff\xff\xff"), fault), nullptr);
  EXPECT_EQ(fault, "Its bytes do not parse.");
  EXPECT_NE(schema->Read({}), nullptr);
}

TEST(DynamicSchema, ReportsWhyADescriptionIsInvalid) {
  EXPECT_THAT(FaultOf({"t.M", Encoding::kPlain, 0, ""}), HasSubstr("t.M are not protobuf"));
  EXPECT_THAT(FaultOf({"t.M", Encoding::kProtobuf, 0, "\xff\xff"}), HasSubstr("is not a FileDescriptorSet"));
  EXPECT_THAT(FaultOf(SchemaWith("name: 'a.proto' dependency: 'missing.proto'", "t.M")),
              HasSubstr("is not valid: a.proto: missing.proto"));
  EXPECT_THAT(FaultOf(SchemaWith("name: 'a.proto' dependency: 'a.proto'", "t.M")),
              HasSubstr("is not valid: a.proto imports itself."));
}

TEST(DynamicSchema, ReadsRecursiveTypesAsDeepAsProtobufAllows) {
  const auto schema =
      Built(SchemaWith("name: 'a.proto' syntax: 'proto3' message_type { name: 'M' field { name: 'm' number: 1 "
                       "label: LABEL_OPTIONAL type: TYPE_MESSAGE type_name: '.M' } }",
                       "M"));
  ASSERT_NE(schema, nullptr);
  EXPECT_NE(schema->Read(AsBytes(std::string("\x0a\x02\x0a\x00", 4))), nullptr);
  std::string deep;
  for (int i = 0; i < 20000; ++i) deep += "\x0b";  // Groups that never end.
  EXPECT_EQ(schema->Read(AsBytes(deep)), nullptr);
}

}  // namespace
}  // namespace hgros::dynamic_schema_test
