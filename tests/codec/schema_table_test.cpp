#include <google/protobuf/descriptor.h>
#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "foxglove/CameraCalibration.pb.h"
#include "foxglove/CompressedVideo.pb.h"
#include "foxglove/JointStates.pb.h"
#include "foxglove/SceneUpdate.pb.h"
#include "support/path.hpp"

namespace hgros {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::DescriptorPool;
using google::protobuf::EnumDescriptor;
using google::protobuf::FieldDescriptor;

std::set<std::string> TableLines() {
  std::ifstream file(test::Path("schema_table"));
  std::set<std::string> lines;
  for (std::string line; std::getline(file, line);) {
    if (!line.empty() && line[0] != '#') lines.insert(line);
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
  for (const std::string& line : from) {
    if (!in.contains(line)) missing.push_back(line);
  }
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
