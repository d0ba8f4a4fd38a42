#include "check/config_schema.hpp"

#include <rapidjson/document.h>
#include <rapidjson/prettywriter.h>
#include <rapidjson/stringbuffer.h>

namespace hgros::cli {
namespace {

rapidjson::Document Parsed() {
  rapidjson::Document schema;
  schema.Parse(ConfigSchemaText().data(), ConfigSchemaText().size());
  return schema;
}

}  // namespace

std::string ConfigSchemaWith(std::span<const std::string> program_sections) {
  if (program_sections.empty()) return std::string(ConfigSchemaText());
  rapidjson::Document schema = Parsed();
  for (const std::string& section : program_sections) {
    if (schema["properties"].HasMember(section.c_str())) continue;
    rapidjson::Value value(rapidjson::kObjectType);
    value.AddMember("description", "A section of the program's own.", schema.GetAllocator());
    schema["properties"].AddMember(rapidjson::Value(section.c_str(), schema.GetAllocator()), value,
                                   schema.GetAllocator());
  }
  rapidjson::StringBuffer text;
  rapidjson::PrettyWriter<rapidjson::StringBuffer> writer(text);
  writer.SetIndent(' ', 2);
  schema.Accept(writer);
  return std::string(text.GetString(), text.GetSize()) + "\n";
}

std::vector<std::string> ConfigSections() {
  std::vector<std::string> sections;
  const rapidjson::Document schema = Parsed();
  for (const auto& member : schema["properties"].GetObject()) sections.emplace_back(member.name.GetString());
  return sections;
}

}  // namespace hgros::cli
