#include "hgros/codec/schema.hpp"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "hgros/internal/codec/fingerprint.hpp"

namespace hgros {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::EnumDescriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::FileDescriptor;

const char* LabelName(const FieldDescriptor& field) {
  if (field.is_repeated()) return "repeated";
  return field.is_required() ? "required" : "optional";
}

std::string MessageText(const Descriptor& type) {
  std::map<int, const FieldDescriptor*> fields;
  for (int i = 0; i < type.field_count(); ++i) fields.emplace(type.field(i)->number(), type.field(i));
  std::string text = "message " + type.full_name() + "\n";
  for (const auto& [number, field] : fields) {
    text += std::to_string(number) + " " + LabelName(*field) + " " + field->type_name() + " ";
    if (field->message_type() != nullptr) text += field->message_type()->full_name() + " ";
    if (field->enum_type() != nullptr) text += field->enum_type()->full_name() + " ";
    text += field->name() + "\n";
  }
  return text;
}

std::string EnumText(const EnumDescriptor& type) {
  std::set<std::pair<int, std::string>> values;
  for (int i = 0; i < type.value_count(); ++i) values.emplace(type.value(i)->number(), type.value(i)->name());
  std::string text = "enum " + type.full_name() + "\n";
  for (const auto& [number, name] : values) text += std::to_string(number) + " " + name + "\n";
  return text;
}

void AddWithImports(const FileDescriptor& file, std::set<const FileDescriptor*>& added,
                    google::protobuf::FileDescriptorSet& set) {
  if (!added.insert(&file).second) return;
  for (int i = 0; i < file.dependency_count(); ++i) AddWithImports(*file.dependency(i), added, set);
  file.CopyTo(set.add_file());
}

}  // namespace

std::string CanonicalSchema(const Descriptor& type) {
  std::map<std::string, std::string> texts;  // By full name: messages and enums share one namespace.
  std::vector<const Descriptor*> open{&type};
  while (!open.empty()) {
    const Descriptor& next = *open.back();
    open.pop_back();
    const auto is_new = [&texts](const auto* used) { return used != nullptr && !texts.contains(used->full_name()); };
    if (!is_new(&next)) continue;
    texts.emplace(next.full_name(), MessageText(next));
    for (int i = 0; i < next.field_count(); ++i) {
      const FieldDescriptor& field = *next.field(i);
      if (is_new(field.message_type())) open.push_back(field.message_type());
      if (is_new(field.enum_type())) texts.emplace(field.enum_type()->full_name(), EnumText(*field.enum_type()));
    }
  }
  std::string canonical = "protobuf 1 " + type.full_name() + "\n";
  for (const auto& [name, text] : texts) canonical += text;
  return canonical;
}

std::uint64_t SchemaFingerprint(const Descriptor& type) { return Fingerprint(CanonicalSchema(type)); }

std::string DescriptorSet(const Descriptor& type) {
  google::protobuf::FileDescriptorSet set;
  std::set<const FileDescriptor*> added;
  AddWithImports(*type.file(), added, set);
  return set.SerializeAsString();
}

const std::string& SchemaName(const Descriptor& type) { return type.full_name(); }

}  // namespace hgros
