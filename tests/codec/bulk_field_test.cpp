#include "hgros/codec/bulk_field.hpp"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <string>

#include "foxglove/Log.pb.h"
#include "foxglove/PointCloud.pb.h"
#include "hgros/base/error.hpp"
#include "hgros/codec/message.hpp"

namespace hgros {
namespace {

using codec::FindBulkField;
using google::protobuf::Descriptor;

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
  [[nodiscard]] const Descriptor& type() const { return *file_->message_type(0); }

 private:
  google::protobuf::DescriptorPool pool_;
  const google::protobuf::FileDescriptor* file_ = nullptr;
};

std::string Field(const std::string& name, int number, const std::string& label = "LABEL_OPTIONAL",
                  const std::string& more = {}) {
  return "field { name: '" + name + "' number: " + std::to_string(number) + " type: TYPE_BYTES label: " + label + " " +
         more + " } ";
}

std::string Refusal(const Descriptor& type, int number) {
  try {
    (void)FindBulkField(type, number);
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

TEST(BulkField, IsTheOnlyFieldOfBytes) {
  EXPECT_EQ(FindBulkField(*foxglove::PointCloud::descriptor(), 0).name(), "data");
  const Schema schema(Field("image", 7) + Field("more", 8, "LABEL_REPEATED"));
  EXPECT_EQ(FindBulkField(schema.type(), 0).number(), 7);
}

TEST(BulkField, IsChosenByNumberWhereThereAreSeveral) {
  const Schema schema(Field("left", 1) + Field("right", 2));
  EXPECT_EQ(FindBulkField(schema.type(), 2).name(), "right");
  EXPECT_NE(Refusal(schema.type(), 0).find("left, right are all of type bytes"), std::string::npos);
  EXPECT_NE(Refusal(schema.type(), 3).find("field 3 of test.M"), std::string::npos);
}

TEST(BulkField, IsNeitherRepeatedNorRequiredNorInAOneof) {
  EXPECT_NE(Refusal(Schema(Field("a", 1, "LABEL_REPEATED")).type(), 0).find("has none"), std::string::npos);
  EXPECT_NE(Refusal(Schema(Field("a", 1, "LABEL_REQUIRED"), "proto2").type(), 0).find("has none"), std::string::npos);
  const Schema choice("oneof_decl { name: 'either' } " + Field("a", 1, "LABEL_OPTIONAL", "oneof_index: 0"));
  EXPECT_NE(Refusal(choice.type(), 0).find("has none"), std::string::npos);
  EXPECT_NE(Refusal(choice.type(), 1).find("no such field"), std::string::npos);
}

TEST(BulkField, MayBeOptional) {
  const Schema optional("oneof_decl { name: '_a' } " +
                        Field("a", 1, "LABEL_OPTIONAL", "proto3_optional: true oneof_index: 0"));
  EXPECT_EQ(FindBulkField(optional.type(), 0).name(), "a");
  EXPECT_EQ(FindBulkField(Schema(Field("a", 1), "proto2").type(), 0).name(), "a");
}

TEST(BulkField, IsCheckedWhenAChannelIsOpened) {
  EXPECT_THROW((void)TypeOf<Bulk<foxglove::Log>>(), Error);
  EXPECT_NO_THROW((void)TypeOf<Bulk<foxglove::PointCloud>>());
}

}  // namespace
}  // namespace hgros
