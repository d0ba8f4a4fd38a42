#include "check/config_schema.hpp"

#include <rapidjson/document.h>
#include <rapidjson/prettywriter.h>
#include <rapidjson/stringbuffer.h>

namespace hgros::cli {
namespace {

rapidjson::Document Parsed(std::string_view text = ConfigSchemaText()) {
  rapidjson::Document schema;
  schema.Parse(text.data(), text.size());
  return schema;
}

std::string TextOf(const rapidjson::Document& schema) {
  rapidjson::StringBuffer text;
  rapidjson::PrettyWriter<rapidjson::StringBuffer> writer(text);
  writer.SetIndent(' ', 2);
  schema.Accept(writer);
  return std::string(text.GetString(), text.GetSize()) + "\n";
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
  return TextOf(schema);
}

std::string RobotSchema() {
  rapidjson::Document schema = Parsed(RobotSchemaText());
  rapidjson::Document config = Parsed();
  rapidjson::Document::AllocatorType& memory = schema.GetAllocator();
  const auto copy = [&memory](const rapidjson::Value& value) { return rapidjson::Value(value, memory); };
  const auto text = [&memory](const std::string& value) { return rapidjson::Value(value.c_str(), memory); };
  rapidjson::Value& definitions = schema["definitions"];
  for (const auto& member : config["definitions"].GetObject()) {
    definitions.AddMember(copy(member.name), copy(member.value), memory);
  }
  definitions.AddMember("nodes", copy(config["properties"]["data_graph"]["properties"]["nodes"]), memory);
  rapidjson::Value& process = schema["properties"]["processes"]["additionalProperties"]["properties"];
  for (const auto& member : config["properties"].GetObject()) {
    const std::string name = "section_" + std::string(member.name.GetString());
    definitions.AddMember(text(name), copy(member.value), memory);
    for (rapidjson::Value* sections : {&schema["properties"], &process}) {
      rapidjson::Value reference(rapidjson::kObjectType);
      reference.AddMember("$ref", text("#/definitions/" + name), memory);
      sections->AddMember(copy(member.name), reference, memory);
    }
  }
  schema.AddMember("$schema", copy(config["$schema"]), memory);
  return TextOf(schema);
}

std::vector<std::string> ConfigSections() {
  std::vector<std::string> sections;
  const rapidjson::Document schema = Parsed();
  for (const auto& member : schema["properties"].GetObject()) sections.emplace_back(member.name.GetString());
  return sections;
}

}  // namespace hgros::cli
