#include "hgros/codec/schema_compatibility.hpp"

#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <random>

#include "foxglove/SceneUpdate.pb.h"
#include "hgros/codec/schema.hpp"

namespace hgros::schema_compatibility_test {
namespace {

using google::protobuf::DescriptorPool;
using google::protobuf::FileDescriptorProto;
using google::protobuf::FileDescriptorSet;
using ::testing::HasSubstr;

FileDescriptorProto FileOf(const std::string& fields, const std::string& syntax = "proto3") {
  FileDescriptorProto file;
  const std::string text = "name: 'f.proto' package: 't' syntax: '" + syntax +
                           "' "
                           "enum_type { name: 'E' value { name: 'A' number: 0 } value { name: 'B' number: 1 } } "
                           "message_type { name: 'Part' field { name: 'p' number: 1 type: TYPE_BOOL "
                           "label: LABEL_OPTIONAL } } "
                           "message_type { name: 'Other' field { name: 'p' number: 1 type: TYPE_STRING "
                           "label: LABEL_OPTIONAL } } "
                           "message_type { name: 'M' " +
                           fields + " }";
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(text, &file)) << text;
  return file;
}

std::string Field(const std::string& type, int number = 1, const std::string& name = "f",
                  const std::string& label = "OPTIONAL", const std::string& type_name = "") {
  return "field { name: '" + name + "' number: " + std::to_string(number) + " type: TYPE_" + type + " label: LABEL_" +
         label + (type_name.empty() ? "" : " type_name: '" + type_name + "'") + " } ";
}

SchemaVerdict Check(const FileDescriptorProto& theirs, const FileDescriptorProto& ours) {
  DescriptorPool pool;
  EXPECT_NE(pool.BuildFile(ours), nullptr);
  FileDescriptorSet set;
  *set.add_file() = theirs;
  return CheckSchemas(set.SerializeAsString(), "t.M", *pool.FindMessageTypeByName("t.M"));
}

SchemaVerdict Check(const std::string& theirs, const std::string& ours) { return Check(FileOf(theirs), FileOf(ours)); }

TEST(SchemaCompatibility, HoldsForTheSameSchema) {
  const auto* const type = foxglove::SceneUpdate::descriptor();
  const SchemaVerdict verdict = CheckSchemas(DescriptorSet(*type), type->full_name(), *type);
  EXPECT_TRUE(verdict.compatible) << verdict.reason;
  EXPECT_TRUE(verdict.notes.empty());
  EXPECT_EQ(verdict.reason, "");
}

TEST(SchemaCompatibility, AllowsAddedAndRemovedFields) {
  EXPECT_TRUE(Check(Field("DOUBLE"), Field("DOUBLE") + Field("STRING", 2, "later")).compatible);
  EXPECT_TRUE(Check(Field("DOUBLE") + Field("STRING", 2, "later"), Field("DOUBLE")).compatible);
  EXPECT_TRUE(Check("", Field("DOUBLE")).compatible);
}

TEST(SchemaCompatibility, FollowsTheWireFamilies) {
  const std::vector<std::vector<std::string>> families = {
      {"INT32", "UINT32", "INT64", "UINT64", "BOOL", "ENUM"},
      {"SINT32", "SINT64"},
      {"FIXED32", "SFIXED32"},
      {"FIXED64", "SFIXED64"},
      {"STRING", "BYTES"},
      {"FLOAT"},
      {"DOUBLE"},
      {"MESSAGE"},
  };
  const auto field = [](const std::string& type) {
    const char* const type_name = type == "ENUM" ? ".t.E" : (type == "MESSAGE" ? ".t.Part" : "");
    return Field(type, 1, "f", "OPTIONAL", type_name);
  };
  for (std::size_t i = 0; i < families.size(); ++i) {
    for (std::size_t k = 0; k < families.size(); ++k) {
      for (const std::string& theirs : families[i]) {
        for (const std::string& ours : families[k]) {
          EXPECT_EQ(Check(field(theirs), field(ours)).compatible, i == k) << theirs << " read as " << ours;
        }
      }
    }
  }
}

TEST(SchemaCompatibility, RefusalNamesMessageNumberAndBothFields) {
  const SchemaVerdict verdict = Check(Field("STRING", 4, "label"), Field("DOUBLE", 4, "weight"));
  EXPECT_FALSE(verdict.compatible);
  EXPECT_EQ(verdict.reason,
            "Field 4 of t.M is \"string label\" there and \"double weight\" here: these are written differently.");
}

TEST(SchemaCompatibility, RefusesListsForSingleValues) {
  EXPECT_FALSE(Check(Field("DOUBLE", 1, "f", "REPEATED"), Field("DOUBLE")).compatible);
  EXPECT_FALSE(Check(Field("DOUBLE"), Field("DOUBLE", 1, "f", "REPEATED")).compatible);
}

TEST(SchemaCompatibility, NotesAFieldWithAnotherName) {
  const SchemaVerdict verdict = Check(Field("DOUBLE", 1, "width"), Field("DOUBLE", 1, "height"));
  EXPECT_TRUE(verdict.compatible);
  ASSERT_EQ(verdict.notes.size(), 1U);
  EXPECT_EQ(verdict.notes[0], "Field 1 of t.M is named \"width\" there and \"height\" here.");
}

TEST(SchemaCompatibility, ComparesNestedMessages) {
  const SchemaVerdict verdict =
      Check(Field("MESSAGE", 1, "part", "OPTIONAL", ".t.Other"), Field("MESSAGE", 1, "part", "OPTIONAL", ".t.Part"));
  EXPECT_FALSE(verdict.compatible);
  EXPECT_THAT(verdict.reason, HasSubstr("Field 1 of t.Part is \"string p\" there and \"bool p\" here"));
}

TEST(SchemaCompatibility, TerminatesForRecursiveTypes) {
  const std::string fields = Field("MESSAGE", 1, "child", "OPTIONAL", ".t.M");
  EXPECT_TRUE(Check(fields, fields).compatible);
}

TEST(SchemaCompatibility, RefusesAMissingRequiredField) {
  const auto required = FileOf(Field("DOUBLE", 1, "f", "REQUIRED"), "proto2");
  const auto optional = FileOf(Field("DOUBLE"), "proto2");
  EXPECT_FALSE(Check(optional, required).compatible);
  EXPECT_FALSE(Check(FileOf("", "proto2"), required).compatible);
  EXPECT_TRUE(Check(required, optional).compatible);
  EXPECT_TRUE(Check(required, required).compatible);
}

TEST(SchemaCompatibility, RefusesAnotherTypeName) {
  const auto* const type = foxglove::SceneUpdate::descriptor();
  const SchemaVerdict verdict = CheckSchemas(DescriptorSet(*type), "foxglove.SceneEntity", *type);
  EXPECT_FALSE(verdict.compatible);
  EXPECT_THAT(verdict.reason, HasSubstr("foxglove.SceneEntity there and foxglove.SceneUpdate here"));
}

TEST(SchemaCompatibility, RefusesInvalidSchemasWithoutLogging) {
  const auto* const type = foxglove::SceneUpdate::descriptor();
  const std::string& name = type->full_name();
  ::testing::internal::CaptureStderr();
  EXPECT_THAT(CheckSchemas("\xff\xff", name, *type).reason, HasSubstr("not a FileDescriptorSet"));
  EXPECT_THAT(CheckSchemas("", name, *type).reason, HasSubstr("does not contain foxglove.SceneUpdate"));
  EXPECT_THAT(CheckSchemas(std::string((1U << 20U) + 1, '\0'), name, *type).reason, HasSubstr("more than 1048576"));

  FileDescriptorSet missing_import;
  type->file()->CopyTo(missing_import.add_file());
  EXPECT_THAT(CheckSchemas(missing_import.SerializeAsString(), name, *type).reason, HasSubstr("not valid"));
  FileDescriptorSet circle;
  circle.add_file()->set_name("a.proto");
  circle.mutable_file(0)->add_dependency("a.proto");
  EXPECT_THAT(CheckSchemas(circle.SerializeAsString(), name, *type).reason, HasSubstr("not valid"));
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

FileDescriptorProto& AddFile(FileDescriptorSet& set) {
  auto& file = *set.add_file();
  file.set_name(std::to_string(set.file_size()));
  return file;
}

std::string RefusalOf(const FileDescriptorSet& set) {
  const auto* const type = foxglove::SceneUpdate::descriptor();
  return CheckSchemas(set.SerializeAsString(), type->full_name(), *type).reason;
}

// Without limits, each of these would cost a pool gigabytes or minutes within a set of 1 MiB.
TEST(SchemaCompatibility, RefusesSchemasThatAreTooExpensive) {
  FileDescriptorSet chain;
  for (int i = 0; i < 300; ++i) {
    auto& file = AddFile(chain);
    if (i == 0) continue;
    file.add_dependency(std::to_string(i));
    file.add_public_dependency(0);
  }
  EXPECT_EQ(RefusalOf(chain), "The peer's schema has more than 256 files.");

  FileDescriptorSet long_name;
  auto& message = *AddFile(long_name).add_message_type();
  message.set_name(std::string(1000, 'M'));
  for (int i = 0; i < 100; ++i) message.add_field();
  EXPECT_EQ(RefusalOf(long_name), "The peer's schema has a name of 1000 bytes, more than 512.");

  FileDescriptorSet long_scopes;
  auto* scope = AddFile(long_scopes).add_message_type();
  for (int i = 0; i < 8; ++i, scope = scope->add_nested_type()) scope->set_name(std::string(100, 'M'));
  EXPECT_THAT(RefusalOf(long_scopes), HasSubstr("a name of 605 bytes"));

  FileDescriptorSet deep;
  scope = AddFile(deep).add_message_type();
  for (int i = 0; i < 40; ++i, scope = scope->add_nested_type()) scope->set_name("M");
  EXPECT_EQ(RefusalOf(deep), "The peer's schema has more than 32 levels of nested types.");

  const std::string counted = "The peer's schema has more than 10000 types, fields, enum values and imports.";
  FileDescriptorSet fields;
  auto& wide = *AddFile(fields).add_message_type();
  for (int i = 0; i < 10'000; ++i) wide.add_field();
  EXPECT_EQ(RefusalOf(fields), counted);
  FileDescriptorSet values;
  auto& type = *AddFile(values).add_enum_type();
  for (int i = 0; i < 10'000; ++i) type.add_value();
  EXPECT_EQ(RefusalOf(values), counted);
}

TEST(SchemaCompatibility, SurvivesRandomDamageWithoutLogging) {
  const auto* const type = foxglove::SceneUpdate::descriptor();
  const std::string good = DescriptorSet(*type);
  std::mt19937 random(20260101);
  int refused = 0;
  ::testing::internal::CaptureStderr();
  for (int round = 0; round < 300; ++round) {
    std::string bad = good;
    for (int k = 0; k < 1 + round % 4; ++k) bad[random() % bad.size()] = static_cast<char>(random());
    if (random() % 4 == 0) bad.resize(random() % bad.size());
    const SchemaVerdict verdict = CheckSchemas(bad, type->full_name(), *type);
    EXPECT_EQ(verdict.compatible, verdict.reason.empty());
    refused += verdict.compatible ? 0 : 1;
  }
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  EXPECT_GT(refused, 0);
}

}  // namespace
}  // namespace hgros::schema_compatibility_test
