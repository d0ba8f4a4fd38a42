// ReadBulk reads the head and the bytes separately, protobuf reads them together. Both must accept the same bytes and
// find the same values.
#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/dynamic_message.h>
#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <random>

#include "foxglove/PointCloud.pb.h"
#include "hgros/codec/bulk_field.hpp"
#include "hgros/internal/codec/bulk_body.hpp"
#include "support/error_of.hpp"
#include "support/seed.hpp"

namespace hgros::bulk_read_test {
namespace {

using codec::FindBulkField;
using google::protobuf::Message;

std::string Hex(std::string_view digits) {
  std::string bytes;
  for (std::size_t i = 0; i + 1 < digits.size(); i += 2) {
    bytes += static_cast<char>(std::stoi(std::string(digits.substr(i, 2)), nullptr, 16));
  }
  return bytes;
}

struct Apart {
  bool read = false;
  std::string whole;  ///< Joined again, in protobuf's own order.
  std::string bulk;
  bool present = false;
};

Apart ReadApart(std::string_view wire, const Message& type) {
  const auto& field = FindBulkField(*type.GetDescriptor(), 0);
  const std::unique_ptr<Message> head(type.New());
  Apart apart;
  Bytes bulk;
  apart.read = codec::ReadBulk(AsBytes(wire), field, *head, bulk, apart.present);
  if (!apart.read) return apart;
  apart.bulk = AsText(bulk);
  EXPECT_TRUE(codec::BytesOf(*head, field).empty());
  if (apart.present && (!bulk.empty() || codec::HasPresence(field))) codec::SetBytes(*head, field, bulk);
  apart.whole = head->SerializePartialAsString();
  return apart;
}

void ExpectAsProtobuf(std::string_view wire, const Message& type) {
  const std::unique_ptr<Message> message(type.New());
  const bool parses = message->ParsePartialFromArray(wire.data(), static_cast<int>(wire.size()));
  const Apart apart = ReadApart(wire, type);
  EXPECT_EQ(apart.read, parses);
  if (apart.read && parses) {
    EXPECT_EQ(apart.whole, message->SerializePartialAsString());
  }
}

foxglove::PointCloud Cloud() {
  foxglove::PointCloud cloud;
  cloud.mutable_timestamp()->set_seconds(12);
  cloud.set_frame_id("lidar");
  cloud.mutable_pose()->mutable_position()->set_x(1.5);
  cloud.set_point_stride(16);
  for (const char* name : {"x", "y", "z"}) {
    auto* field = cloud.add_fields();
    field->set_name(name);
    field->set_type(foxglove::PackedElementField::FLOAT32);
  }
  cloud.set_data("the points");
  return cloud;
}

/// A message type "test.M" with the given fields, in the text form of descriptors.
class Schema {
 public:
  explicit Schema(const std::string& fields, const std::string& syntax = "proto3") {
    google::protobuf::FileDescriptorProto file;
    EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(
        "name: 'm.proto' package: 'test' syntax: '" + syntax + "' message_type { name: 'M' " + fields + " }", &file));
    file_ = pool_.BuildFile(file);
    EXPECT_NE(file_, nullptr);
  }
  [[nodiscard]] const google::protobuf::Descriptor& type() const { return *file_->message_type(0); }

 private:
  google::protobuf::DescriptorPool pool_;
  const google::protobuf::FileDescriptor* file_ = nullptr;
};

std::string Field(const std::string& name, int number, const std::string& label = "LABEL_OPTIONAL",
                  const std::string& more = {}) {
  return "field { name: '" + name + "' number: " + std::to_string(number) + " type: TYPE_BYTES label: " + label + " " +
         more + " } ";
}

std::string RefusalOf(const google::protobuf::Descriptor& type, int number) {
  return test::ErrorOf([&] { (void)FindBulkField(type, number); });
}

TEST(BulkField, IsTheOnlyFieldOfBytes) {
  EXPECT_EQ(FindBulkField(*foxglove::PointCloud::descriptor(), 0).name(), "data");
  const Schema schema(Field("image", 7) + Field("more", 8, "LABEL_REPEATED"));
  EXPECT_EQ(FindBulkField(schema.type(), 0).number(), 7);
}

TEST(BulkField, IsChosenByNumberWhereThereAreSeveral) {
  const Schema schema(Field("left", 1) + Field("right", 2));
  EXPECT_EQ(FindBulkField(schema.type(), 2).name(), "right");
  EXPECT_NE(RefusalOf(schema.type(), 0).find("left, right are all of type bytes"), std::string::npos);
  EXPECT_NE(RefusalOf(schema.type(), 3).find("field 3 of test.M"), std::string::npos);
}

TEST(BulkField, IsNeitherRepeatedNorRequiredNorInAOneof) {
  EXPECT_NE(RefusalOf(Schema(Field("a", 1, "LABEL_REPEATED")).type(), 0).find("has none"), std::string::npos);
  EXPECT_NE(RefusalOf(Schema(Field("a", 1, "LABEL_REQUIRED"), "proto2").type(), 0).find("has none"), std::string::npos);
  const Schema choice("oneof_decl { name: 'either' } " + Field("a", 1, "LABEL_OPTIONAL", "oneof_index: 0"));
  EXPECT_NE(RefusalOf(choice.type(), 0).find("has none"), std::string::npos);
  EXPECT_NE(RefusalOf(choice.type(), 1).find("no such field"), std::string::npos);
}

TEST(BulkField, MayBeOptional) {
  const Schema optional("oneof_decl { name: '_a' } " +
                        Field("a", 1, "LABEL_OPTIONAL", "proto3_optional: true oneof_index: 0"));
  EXPECT_EQ(FindBulkField(optional.type(), 0).name(), "a");
  EXPECT_EQ(FindBulkField(Schema(Field("a", 1), "proto2").type(), 0).name(), "a");
}

TEST(ReadBulk, FindsTheBytesAtAnyPlace) {
  foxglove::PointCloud before = Cloud(), after = Cloud(), only;
  after.clear_data();
  before.clear_fields();
  only.set_data("the points");
  for (const std::string& wire :
       {Cloud().SerializeAsString(), only.SerializeAsString() + after.SerializeAsString(),
        after.SerializeAsString() + only.SerializeAsString() + before.SerializeAsString(), only.SerializeAsString()}) {
    ExpectAsProtobuf(wire, foxglove::PointCloud());
    EXPECT_EQ(ReadApart(wire, foxglove::PointCloud()).bulk, "the points");
  }
}

TEST(ReadBulk, ShowsTheBytesInPlace) {
  const std::string wire = Cloud().SerializeAsString();
  foxglove::PointCloud head;
  Bytes bulk;
  bool present = false;
  ASSERT_TRUE(codec::ReadBulk(AsBytes(wire), FindBulkField(*head.GetDescriptor(), 0), head, bulk, present));
  EXPECT_TRUE(present);
  EXPECT_EQ(AsText(bulk).data(), wire.data() + wire.size() - 10);
}

TEST(ReadBulk, UsesTheLastOccurrenceOfTheField) {
  const std::string first = Hex("3203616161"), second = Hex("32026262"), empty = Hex("3200");
  ExpectAsProtobuf(first + second, foxglove::PointCloud());
  EXPECT_EQ(ReadApart(first + second, foxglove::PointCloud()).bulk, "bb");
  EXPECT_EQ(ReadApart(first + second + empty, foxglove::PointCloud()).bulk, "");
}

TEST(ReadBulk, KeepsUnknownFields) {
  const std::string unknown = Hex("f83f2a") + Hex("fa3f0161") + Hex("fb3f0801fc3f") + Hex("fd3f01020304");
  foxglove::PointCloud head;
  Bytes bulk;
  bool present = false;
  const std::string wire = unknown + Cloud().SerializeAsString() + unknown;
  ASSERT_TRUE(codec::ReadBulk(AsBytes(wire), FindBulkField(*head.GetDescriptor(), 0), head, bulk, present));
  EXPECT_EQ(AsText(bulk), "the points");
  EXPECT_NE(head.SerializeAsString().find(unknown + unknown), std::string::npos);
  ExpectAsProtobuf(wire, foxglove::PointCloud());
}

TEST(ReadBulk, RefusesTheSameBytesAsProtobuf) {
  const char* const wires[] = {
      "320361",                // Cut within the bytes.
      "32",                    // Without a length.
      "32ffffffff0f",          // A length of 4 GiB.
      "32ffffffffffffffff01",  // A length without end.
      "0001",                  // Field 0.
      "04",                    // The end of a group without a start.
      "f33f",                  // A group without end.
      "f33ffc3f",              // The end of another group.
      "36",                    // A wire type that does not exist.
      "37",                    // Another one.
      "ffffffffff",            // A tag without end.
      "12",                    // Cut at another field's length.
      "1202c328",              // A string that is not UTF-8.
      "0afe01",                // Cut within a message.
      "25010203",              // Cut within a fixed32.
      "21",                    // Cut within a fixed64.
      "f83f8080",              // Cut within a varint.
      "f83fffffffffffffffffffff01",
  };
  for (const char* digits : wires) {
    SCOPED_TRACE(digits);
    EXPECT_FALSE(ReadApart(Hex(digits), foxglove::PointCloud()).read);
    ExpectAsProtobuf(Hex(digits), foxglove::PointCloud());
  }
}

TEST(ReadBulk, ReadsOverlongVarintsAndOtherWireTypesLikeProtobuf) {
  for (const char* digits : {"b2000161", "b28080800001ff", "3281800061", "3001", "3501020304", "33013401", "330834",
                             "b2808080700161", "b280808080700161"}) {
    SCOPED_TRACE(digits);
    ExpectAsProtobuf(Hex(digits), foxglove::PointCloud());
  }
}

TEST(ReadBulk, SkipsDeepGroupsWithoutStack) {
  std::string deep;
  for (int i = 0; i < 200'000; ++i) deep += Hex("f33f");
  ExpectAsProtobuf(deep, foxglove::PointCloud());
  for (int i = 0; i < 200'000; ++i) deep += Hex("fc3f");
  ExpectAsProtobuf(deep, foxglove::PointCloud());
  std::string shallow;
  for (int i = 0; i < 50; ++i) shallow = Hex("f33f") + shallow + Hex("fc3f");
  ExpectAsProtobuf(shallow + Hex("32026161"), foxglove::PointCloud());
}

TEST(ReadBulk, DistinguishesEmptyFromMissingFieldIfTheSchemaDoes) {
  const Schema schema(Field("a", 1) + "field { name: 'b' number: 2 type: TYPE_INT32 label: LABEL_REQUIRED }", "proto2");
  google::protobuf::DynamicMessageFactory factory;
  const Message& type = *factory.GetPrototype(&schema.type());
  for (const char* digits : {"0a001001", "1001", "0a016110010a00", "0a0161"}) {
    SCOPED_TRACE(digits);
    ExpectAsProtobuf(Hex(digits), type);
  }
}

TEST(ReadBulk, AgreesWithProtobufOnRandomChanges) {
  std::mt19937 random(test::Seed());
  const std::string good = Cloud().SerializeAsString();
  const auto any = [&random](std::size_t below) {
    return std::uniform_int_distribution<std::size_t>(0, below - 1)(random);
  };
  for (int round = 0; round < 20'000; ++round) {
    std::string wire = good;
    for (std::size_t change = any(4); change-- > 0 && !wire.empty();) {
      switch (any(4)) {
        case 0: wire[any(wire.size())] = static_cast<char>(any(256)); break;
        case 1: wire.erase(any(wire.size()), 1 + any(4)); break;
        case 2: wire.insert(any(wire.size()), Hex("3203616263")); break;
        default: wire += good.substr(any(good.size())); break;
      }
    }
    ExpectAsProtobuf(wire, foxglove::PointCloud());
    if (HasFailure()) {
      FAIL() << ::testing::PrintToString(wire);
    }
  }
}

}  // namespace
}  // namespace hgros::bulk_read_test
