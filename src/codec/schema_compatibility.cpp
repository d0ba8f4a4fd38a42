#include "hgros/codec/schema_compatibility.hpp"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/stubs/logging.h>

#include <set>
#include <utility>

namespace hgros {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::DescriptorPool;
using google::protobuf::DescriptorProto;
using google::protobuf::EnumDescriptorProto;
using google::protobuf::FieldDescriptor;
using google::protobuf::FileDescriptorProto;
using google::protobuf::FileDescriptorSet;

// Real sets have some ten kilobytes; what is hostile should not cost us more than some tens of milliseconds.
constexpr std::size_t kMaxSetBytes = 1 << 20;
constexpr int kMaxFiles = 256;
constexpr std::size_t kMaxNameBytes = 512;
constexpr std::size_t kMaxDeclarations = 10'000;
constexpr int kMaxNesting = 32;
constexpr std::size_t kMaxComparedPairs = 10'000;
constexpr std::size_t kMaxNotes = 16;

enum class Family { kVarint, kZigzag, kFixed32, kFixed64, kFloat, kDouble, kBytes, kMessage, kGroup };

Family FamilyOf(const FieldDescriptor& field) {
  switch (field.type()) {
    case FieldDescriptor::TYPE_INT32:
    case FieldDescriptor::TYPE_INT64:
    case FieldDescriptor::TYPE_UINT32:
    case FieldDescriptor::TYPE_UINT64:
    case FieldDescriptor::TYPE_BOOL:
    case FieldDescriptor::TYPE_ENUM: return Family::kVarint;
    case FieldDescriptor::TYPE_SINT32:
    case FieldDescriptor::TYPE_SINT64: return Family::kZigzag;
    case FieldDescriptor::TYPE_FIXED32:
    case FieldDescriptor::TYPE_SFIXED32: return Family::kFixed32;
    case FieldDescriptor::TYPE_FIXED64:
    case FieldDescriptor::TYPE_SFIXED64: return Family::kFixed64;
    case FieldDescriptor::TYPE_FLOAT: return Family::kFloat;
    case FieldDescriptor::TYPE_DOUBLE: return Family::kDouble;
    case FieldDescriptor::TYPE_STRING:
    case FieldDescriptor::TYPE_BYTES: return Family::kBytes;
    case FieldDescriptor::TYPE_MESSAGE: return Family::kMessage;
    case FieldDescriptor::TYPE_GROUP: return Family::kGroup;
  }
  return Family::kGroup;
}

/// Collects instead of logging.
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

/// Finds what would make a pool spend far more than the set's own size: it stores every declaration's full name, and
/// follows public imports from every file to all before it.
class SizeCheck {
 public:
  /// What is too large, or an empty text.
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
  /// The length of the full name of `name` in a scope whose own has `scope` bytes.
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

// What the comparison does not read is taken out before the set is built: options, defaults, ranges and services are
// where a hostile set could make building slow.
void Reduce(EnumDescriptorProto& type) {
  if (type.value_size() > 1) type.mutable_value()->DeleteSubrange(1, type.value_size() - 1);
  for (auto& value : *type.mutable_value()) value.clear_options();
  type.clear_options();
  type.clear_reserved_range();
  type.clear_reserved_name();
}

void Reduce(DescriptorProto& type) {
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
  for (auto& nested : *type.mutable_nested_type()) Reduce(nested);
  for (auto& nested : *type.mutable_enum_type()) Reduce(nested);
}

void Reduce(FileDescriptorProto& file) {
  file.clear_options();
  file.clear_service();
  file.clear_extension();
  file.clear_source_code_info();
  for (auto& type : *file.mutable_message_type()) Reduce(type);
  for (auto& type : *file.mutable_enum_type()) Reduce(type);
}

std::string Describe(const FieldDescriptor& field) {
  std::string text = field.is_repeated() ? "repeated " : (field.is_required() ? "required " : "");
  if (field.message_type() != nullptr) {
    text += field.message_type()->full_name();
  } else if (field.enum_type() != nullptr) {
    text += field.enum_type()->full_name();
  } else {
    text += field.type_name();
  }
  return text + " " + field.name();
}

std::string Place(const Descriptor& message, int number) {
  return "Field " + std::to_string(number) + " of " + message.full_name();
}

/// Why a field that both sides know cannot be read, or an empty text.
std::string FieldFault(const FieldDescriptor& theirs, const FieldDescriptor& ours) {
  const std::string pair = " is \"" + Describe(theirs) + "\" there and \"" + Describe(ours) + "\" here";
  const std::string place = Place(*ours.containing_type(), ours.number());
  if (FamilyOf(theirs) != FamilyOf(ours)) return place + pair + ": these are written differently.";
  if (theirs.is_repeated() != ours.is_repeated()) return place + pair + ": one side sends a list, the other one value.";
  if (ours.is_required() && !theirs.is_required()) return place + pair + ": it may be missing.";
  return {};
}

SchemaVerdict Refuse(std::string reason) { return {false, std::move(reason), {}}; }

SchemaVerdict Compare(const Descriptor& their_root, const Descriptor& our_root) {
  using Pair = std::pair<const Descriptor*, const Descriptor*>;
  SchemaVerdict verdict{true, {}, {}};
  std::set<Pair> seen{{&their_root, &our_root}};
  std::vector<Pair> open{{&their_root, &our_root}};
  while (!open.empty()) {
    const auto [theirs, ours] = open.back();
    open.pop_back();
    for (int i = 0; i < ours->field_count(); ++i) {
      const FieldDescriptor& our_field = *ours->field(i);
      const FieldDescriptor* const their_field = theirs->FindFieldByNumber(our_field.number());
      if (their_field == nullptr) {
        if (!our_field.is_required()) continue;
        return Refuse(Place(*ours, our_field.number()) + " is \"" + Describe(our_field) + "\" here and unknown there.");
      }
      std::string fault = FieldFault(*their_field, our_field);
      if (!fault.empty()) return Refuse(std::move(fault));
      if (their_field->name() != our_field.name() && verdict.notes.size() < kMaxNotes) {
        verdict.notes.push_back(Place(*ours, our_field.number()) + " is named \"" + their_field->name() +
                                "\" there and \"" + our_field.name() + "\" here.");
      }
      if (our_field.message_type() == nullptr) continue;
      const Pair next{their_field->message_type(), our_field.message_type()};
      if (seen.size() >= kMaxComparedPairs) return Refuse("The schemas are too large to be compared.");
      if (seen.insert(next).second) open.push_back(next);
    }
  }
  return verdict;
}

}  // namespace

SchemaVerdict CheckSchemas(std::string_view their_descriptor_set, const std::string& their_type_name,
                           const Descriptor& ours) {
  if (their_type_name != ours.full_name()) {
    return Refuse("The type is " + their_type_name + " there and " + ours.full_name() + " here.");
  }
  if (their_descriptor_set.size() > kMaxSetBytes) {
    return Refuse("The peer's schema has " + std::to_string(their_descriptor_set.size()) + " bytes, more than " +
                  std::to_string(kMaxSetBytes) + ".");
  }
  // protobuf writes a line to standard error for every name that is not UTF-8, as often as a peer likes.
  const google::protobuf::LogSilencer silence;
  FileDescriptorSet set;
  if (!set.ParsePartialFromArray(their_descriptor_set.data(), static_cast<int>(their_descriptor_set.size())) ||
      !set.IsInitialized()) {
    return Refuse("The peer's schema is not a FileDescriptorSet.");
  }
  if (const std::string fault = SizeCheck().Fault(set); !fault.empty()) {
    return Refuse("The peer's schema has " + fault + ".");
  }
  DescriptorPool pool;
  for (FileDescriptorProto& file : *set.mutable_file()) {
    Reduce(file);
    FirstError error;
    if (pool.BuildFileCollectingErrors(file, &error) == nullptr) {
      return Refuse("The peer's schema is not valid: " + error.text());
    }
  }
  const Descriptor* const theirs = pool.FindMessageTypeByName(their_type_name);
  if (theirs == nullptr) return Refuse("The peer's schema does not contain " + their_type_name + ".");
  return Compare(*theirs, ours);
}

}  // namespace hgros
