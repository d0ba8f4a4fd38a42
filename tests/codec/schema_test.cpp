#include "hgros/codec/schema.hpp"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>

#include "foxglove/CameraCalibration.pb.h"
#include "foxglove/CompressedVideo.pb.h"
#include "foxglove/FrameTransform.pb.h"
#include "foxglove/JointStates.pb.h"
#include "foxglove/SceneUpdate.pb.h"
#include "foxglove/Vector3.pb.h"
#include "hgros/internal/codec/fingerprint.hpp"
#include "support/path.hpp"

namespace hgros {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::DescriptorPool;
using google::protobuf::EnumDescriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::FileDescriptorProto;
using google::protobuf::FileDescriptorSet;

/// The fingerprint of message t.M in a file given in protobuf's text format.
std::uint64_t FingerprintOf(const std::string& file_text) {
  FileDescriptorProto file;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(file_text, &file));
  DescriptorPool pool;
  EXPECT_NE(pool.BuildFile(file), nullptr);
  return SchemaFingerprint(*pool.FindMessageTypeByName("t.M"));
}

std::string File(const std::string& fields, const std::string& name = "f.proto") {
  return "name: '" + name + "' package: 't' syntax: 'proto3' enum_type { name: 'E' value { name: 'A' number: 0 } } " +
         "message_type { name: 'M' " + fields + " }";
}

const std::string kX = "field { name: 'x' number: 1 type: TYPE_DOUBLE label: LABEL_OPTIONAL } ";
const std::string kY = "field { name: 'y' number: 2 type: TYPE_DOUBLE label: LABEL_OPTIONAL } ";

TEST(Fingerprint, IsFnv1a) {
  EXPECT_EQ(Fingerprint(""), 0xcbf29ce484222325U);
  EXPECT_EQ(Fingerprint("a"), 0xaf63dc4c8601ec8cU);
  EXPECT_EQ(Fingerprint("foobar"), 0x85944171f73967e8U);
}

TEST(SchemaFingerprint, IsTheHashOfTheCanonicalText) {
  EXPECT_EQ(CanonicalSchema(*foxglove::Vector3::descriptor()),
            "protobuf 1 foxglove.Vector3\n"
            "message foxglove.Vector3\n"
            "1 optional double x\n"
            "2 optional double y\n"
            "3 optional double z\n");
}

TEST(SchemaFingerprint, CoversReachableMessagesAndEnums) {
  const std::string text = CanonicalSchema(*foxglove::SceneUpdate::descriptor());
  EXPECT_NE(text.find("message foxglove.LinePrimitive\n"
                      "1 optional enum foxglove.LinePrimitive.Type type\n"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("enum foxglove.LinePrimitive.Type\n0 LINE_STRIP\n1 LINE_LOOP\n2 LINE_LIST\n"), std::string::npos);
  EXPECT_NE(text.find("message google.protobuf.Duration\n"), std::string::npos);
  EXPECT_EQ(text.find("foxglove.PointCloud"), std::string::npos);
}

// Each type is written once. It was written again for each field that has it, which took 10 s here.
TEST(SchemaFingerprint, IsQuickForManyFieldsOfAType) {
  FileDescriptorProto file;
  ASSERT_TRUE(google::protobuf::TextFormat::ParseFromString(File(""), &file));
  for (int number = 1; number <= 9000; ++number) {
    auto& field = *file.mutable_message_type(0)->add_field();
    field.set_name("f" + std::to_string(number));
    field.set_number(number);
    field.set_label(google::protobuf::FieldDescriptorProto::LABEL_OPTIONAL);
    field.set_type_name(number % 2 == 0 ? ".t.M" : ".t.E");
  }
  DescriptorPool pool;
  ASSERT_NE(pool.BuildFile(file), nullptr);
  const std::string text = CanonicalSchema(*pool.FindMessageTypeByName("t.M"));
  EXPECT_EQ(text.find("message t.M\n"), text.rfind("message t.M\n"));
  EXPECT_NE(text.find("9000 optional message t.M f9000\n"), std::string::npos);
}

TEST(SchemaFingerprint, StaysTheSameForever) {
  EXPECT_EQ(SchemaFingerprint(*foxglove::Vector3::descriptor()), 0xe77328b18d56202aU);
  EXPECT_EQ(SchemaFingerprint(*foxglove::FrameTransform::descriptor()), 0x94b3ed65d36ffdfaU);
}

TEST(SchemaFingerprint, IgnoresOrderAndFile) {
  EXPECT_EQ(FingerprintOf(File(kX + kY)), FingerprintOf(File(kY + kX, "moved/elsewhere.proto")));
}

TEST(SchemaFingerprint, ChangesWithEveryChangeOfMeaning) {
  const std::string cases[] = {
      kX,
      kX + kY,
      "field { name: 'z' number: 1 type: TYPE_DOUBLE label: LABEL_OPTIONAL } ",
      "field { name: 'x' number: 3 type: TYPE_DOUBLE label: LABEL_OPTIONAL } ",
      "field { name: 'x' number: 1 type: TYPE_FLOAT label: LABEL_OPTIONAL } ",
      "field { name: 'x' number: 1 type: TYPE_DOUBLE label: LABEL_REPEATED } ",
      "field { name: 'x' number: 1 type: TYPE_ENUM type_name: '.t.E' label: LABEL_OPTIONAL } ",
      "field { name: 'x' number: 1 type: TYPE_MESSAGE type_name: '.t.M' label: LABEL_OPTIONAL } ",
  };
  std::set<std::uint64_t> seen;
  for (const std::string& fields : cases) EXPECT_TRUE(seen.insert(FingerprintOf(File(fields))).second) << fields;
}

TEST(DescriptorSet, HasEveryImportOnceBeforeItsUserAndIsEnoughToBuildTheTypeElsewhere) {
  FileDescriptorSet set;
  ASSERT_TRUE(set.ParseFromString(DescriptorSet(*foxglove::SceneUpdate::descriptor())));
  std::set<std::string> seen;
  DescriptorPool pool;
  for (const FileDescriptorProto& file : set.file()) {
    for (const std::string& import : file.dependency()) EXPECT_TRUE(seen.contains(import)) << import;
    EXPECT_TRUE(seen.insert(file.name()).second) << file.name();
    ASSERT_NE(pool.BuildFile(file), nullptr);
  }
  EXPECT_TRUE(seen.contains("google/protobuf/timestamp.proto"));
  EXPECT_EQ(set.file(set.file_size() - 1).name(), "foxglove/SceneUpdate.proto");
  const auto* const rebuilt = pool.FindMessageTypeByName("foxglove.SceneUpdate");
  ASSERT_NE(rebuilt, nullptr);
  EXPECT_EQ(SchemaFingerprint(*rebuilt), SchemaFingerprint(*foxglove::SceneUpdate::descriptor()));
}

// One line for each field and each value of an enum.
std::set<std::string> TableLines() {
  std::ifstream file(test::Path("schema_table"));
  std::set<std::string> lines;
  std::string type;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    if (line[0] != ' ') {
      type = line.substr(0, line.find(':'));
      line.erase(0, type.size() + 1);
    }
    std::istringstream entries(line);
    for (std::string entry; std::getline(entries >> std::ws, entry, ',');) lines.insert(type + " " + entry);
  }
  return lines;
}

void AddLines(const Descriptor& message, std::set<std::string>& lines) {
  for (int i = 0; i < message.field_count(); ++i) {
    const FieldDescriptor& field = *message.field(i);
    std::string type = field.type_name();
    if (field.message_type() != nullptr) type = field.message_type()->full_name();
    if (field.enum_type() != nullptr) type = field.enum_type()->full_name();
    lines.insert("message " + message.full_name() + " " + std::to_string(field.number()) + " " + field.name() + " " +
                 (field.is_repeated() ? "repeated " : "") + type);
  }
  for (int i = 0; i < message.enum_type_count(); ++i) {
    const EnumDescriptor& type = *message.enum_type(i);
    for (int k = 0; k < type.value_count(); ++k) {
      lines.insert("enum " + type.full_name() + " " + type.value(k)->name() + " " +
                   std::to_string(type.value(k)->number()));
    }
  }
}

/// Every message of package foxglove in the shared library: those with names from the table, and those in the files
/// that these import.
std::set<std::string> CompiledLines(const std::set<std::string>& table) {
  std::set<std::string> names;
  for (const std::string& line : table) {
    std::istringstream words(line);
    std::string kind;
    std::string name;
    words >> kind >> name;
    if (kind == "message") names.insert(name);
  }
  std::set<std::string> lines;
  for (const std::string& name : names) {
    const Descriptor* const message = DescriptorPool::generated_pool()->FindMessageTypeByName(name);
    EXPECT_NE(message, nullptr) << name << " is in the table but not compiled";
    if (message == nullptr) continue;
    EXPECT_EQ(message->file()->message_type_count(), 1) << message->file()->name();
    EXPECT_EQ(message->file()->name(), "foxglove/" + message->name() + ".proto");
    AddLines(*message, lines);
  }
  return lines;
}

std::vector<std::string> Missing(const std::set<std::string>& from, const std::set<std::string>& in) {
  std::vector<std::string> missing;
  std::ranges::set_difference(from, in, std::back_inserter(missing));
  return missing;
}

TEST(SchemaTable, AgreesWithTheCompiledMessagesInBothDirections) {
  const std::set<std::string> table = TableLines();
  ASSERT_GT(table.size(), 150U);
  const std::set<std::string> compiled = CompiledLines(table);
  EXPECT_EQ(Missing(table, compiled), std::vector<std::string>{}) << "in the table, not compiled";
  EXPECT_EQ(Missing(compiled, table), std::vector<std::string>{}) << "compiled, not in the table";
}

}  // namespace
}  // namespace hgros
