#include "codec/foreign_schema.hpp"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/stubs/logging.h>

#include <utility>

namespace hgros {
namespace {

using google::protobuf::DescriptorPool;
using google::protobuf::DescriptorProto;
using google::protobuf::EnumDescriptorProto;
using google::protobuf::FileDescriptorProto;
using google::protobuf::FileDescriptorSet;

// Real sets have about ten kilobytes. A hostile set must not cost more than some tens of milliseconds.
constexpr std::size_t kMaxSetBytes = 1 << 20;
constexpr int kMaxFiles = 256;
constexpr std::size_t kMaxNameBytes = 512;
constexpr std::size_t kMaxDeclarations = 10'000;
constexpr int kMaxNesting = 32;

/// Keeps the first error instead of logging errors.
class FirstError : public DescriptorPool::ErrorCollector {
 public:
  void AddError(const std::string& file, const std::string& element, const google::protobuf::Message*, ErrorLocation,
                const std::string& message) override {
    if (text_.empty()) text_ = file + ": " + element + ": " + message;
  }
  void AddWarning(const std::string&, const std::string&, const google::protobuf::Message*, ErrorLocation,
                  const std::string&) override {}
  [[nodiscard]] const std::string& text() const noexcept { return text_; }

 private:
  std::string text_;
};

/// Finds parts that would make a pool far larger than the set: a pool stores the full name of every declaration, and
/// follows the public imports of every file.
class SizeCheck {
 public:
  /// Describes the part that is too large; an empty text if none is.
  [[nodiscard]] std::string Fault(const FileDescriptorSet& set) {
    if (set.file_size() > kMaxFiles) TooMany("files", kMaxFiles);
    for (const auto& file : set.file()) {
      if (!fault_.empty()) break;
      Name(0, file.name());
      for (const auto& import : file.dependency()) Name(0, import);
      Count(file.dependency_size() + file.public_dependency_size() + file.weak_dependency_size());
      const std::size_t package = Name(0, file.package());
      for (const auto& type : file.message_type()) Message(package, type, 1);
      for (const auto& type : file.enum_type()) Enum(package, type);
    }
    return std::move(fault_);
  }

 private:
  void Message(std::size_t scope, const DescriptorProto& type, int depth) {
    if (depth > kMaxNesting) TooMany("levels of nested types", kMaxNesting);
    if (!fault_.empty()) return;
    const std::size_t inside = Name(scope, type.name());
    Count(1 + type.field_size() + type.oneof_decl_size());
    for (const auto& field : type.field()) {
      Name(inside, field.name());
      Name(0, field.type_name());
      Name(0, field.extendee());
    }
    for (const auto& oneof : type.oneof_decl()) Name(inside, oneof.name());
    for (const auto& nested : type.nested_type()) Message(inside, nested, depth + 1);
    for (const auto& nested : type.enum_type()) Enum(inside, nested);
  }
  void Enum(std::size_t scope, const EnumDescriptorProto& type) {
    Name(scope, type.name());
    Count(1 + type.value_size());
    for (const auto& value : type.value()) Name(scope, value.name());
  }
  /// The length of the full name of `name` in a scope whose full name has `scope` bytes.
  std::size_t Name(std::size_t scope, const std::string& name) {
    const std::size_t full = scope + (scope > 0 ? 1 : 0) + name.size();
    if (full > kMaxNameBytes && fault_.empty()) {
      fault_ = "a name of " + std::to_string(full) + " bytes, more than " + std::to_string(kMaxNameBytes);
    }
    return full;
  }
  void Count(int declarations) {
    declarations_ += static_cast<std::size_t>(declarations);
    if (declarations_ > kMaxDeclarations) TooMany("types, fields, enum values and imports", kMaxDeclarations);
  }
  void TooMany(std::string_view what, std::size_t most) {
    if (fault_.empty()) fault_ = "more than " + std::to_string(most) + " " + std::string(what);
  }

  std::size_t declarations_ = 0;
  std::string fault_;
};

// Removes unused parts before the set is built: options, defaults, ranges and services. A hostile set could use them to
// make building slow.
void Reduce(EnumDescriptorProto& type, EnumValues values) {
  if (values == EnumValues::kLeftOut && type.value_size() > 1)
    type.mutable_value()->DeleteSubrange(1, type.value_size() - 1);
  for (auto& value : *type.mutable_value()) value.clear_options();
  const bool aliases = type.options().allow_alias();
  type.clear_options();
  if (aliases && values == EnumValues::kKept) type.mutable_options()->set_allow_alias(true);
  type.clear_reserved_range();
  type.clear_reserved_name();
}

void Reduce(DescriptorProto& type, EnumValues values) {
  type.clear_extension();
  type.clear_extension_range();
  type.clear_options();
  type.clear_reserved_range();
  type.clear_reserved_name();
  for (auto& oneof : *type.mutable_oneof_decl()) oneof.clear_options();
  for (auto& field : *type.mutable_field()) {
    field.clear_options();
    field.clear_default_value();
    field.clear_json_name();
  }
  for (auto& nested : *type.mutable_nested_type()) Reduce(nested, values);
  for (auto& nested : *type.mutable_enum_type()) Reduce(nested, values);
}

void Reduce(FileDescriptorProto& file, EnumValues values) {
  file.clear_options();
  file.clear_service();
  file.clear_extension();
  file.clear_source_code_info();
  for (auto& type : *file.mutable_message_type()) Reduce(type, values);
  for (auto& type : *file.mutable_enum_type()) Reduce(type, values);
}

ForeignSchema Refuse(std::string fault) { return {nullptr, nullptr, std::move(fault)}; }

}  // namespace

ForeignSchema BuildForeignSchema(std::string_view descriptor_set, const std::string& type_name,
                                 EnumValues enum_values) {
  if (descriptor_set.size() > kMaxSetBytes) {
    return Refuse("has " + std::to_string(descriptor_set.size()) + " bytes, more than " + std::to_string(kMaxSetBytes) +
                  ".");
  }
  // Without this, protobuf would write a line to standard error for every name that is not UTF-8.
  const google::protobuf::LogSilencer silence;
  FileDescriptorSet set;
  if (!set.ParsePartialFromArray(descriptor_set.data(), static_cast<int>(descriptor_set.size())) ||
      !set.IsInitialized()) {
    return Refuse("is not a FileDescriptorSet.");
  }
  if (const std::string fault = SizeCheck().Fault(set); !fault.empty()) return Refuse("has " + fault + ".");
  auto pool = std::make_shared<DescriptorPool>();
  for (FileDescriptorProto& file : *set.mutable_file()) {
    Reduce(file, enum_values);
    FirstError error;
    if (pool->BuildFileCollectingErrors(file, &error) != nullptr) continue;
    // Protobuf tells no error for a file that imports itself.
    return Refuse("is not valid: " + (error.text().empty() ? file.name() + " imports itself." : error.text()));
  }
  const auto* const type = pool->FindMessageTypeByName(type_name);
  if (type == nullptr) return Refuse("does not contain " + type_name + ".");
  return {std::move(pool), type, {}};
}

}  // namespace hgros
