#include "viewer/data/messages/field_path.hpp"

#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <charconv>

namespace hgros::viewer {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

constexpr std::size_t kMaxSteps = 8;

bool IsTime(const Descriptor* type) {
  return type != nullptr &&
         (type->full_name() == "google.protobuf.Timestamp" || type->full_name() == "google.protobuf.Duration") &&
         type->FindFieldByName("seconds") != nullptr && type->FindFieldByName("nanos") != nullptr;
}

bool IsNumber(const FieldDescriptor& field) {
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_STRING: return false;
    case FieldDescriptor::CPPTYPE_MESSAGE: return IsTime(field.message_type());
    default: return true;
  }
}

std::optional<double> SecondsOf(const Message& message) {
  const Descriptor& type = *message.GetDescriptor();
  const FieldDescriptor &seconds = *type.FindFieldByName("seconds"), &nanos = *type.FindFieldByName("nanos");
  if (seconds.cpp_type() != FieldDescriptor::CPPTYPE_INT64 || nanos.cpp_type() != FieldDescriptor::CPPTYPE_INT32 ||
      seconds.is_repeated() || nanos.is_repeated()) {
    return std::nullopt;
  }
  const Reflection& reflection = *message.GetReflection();
  return static_cast<double>(reflection.GetInt64(message, &seconds)) +
         1e-9 * static_cast<double>(reflection.GetInt32(message, &nanos));
}

std::optional<double> ValueOf(const Message& message, const FieldDescriptor& field, int index) {
  const Reflection& r = *message.GetReflection();
  const bool one = index < 0;
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_INT32:
      return one ? r.GetInt32(message, &field) : r.GetRepeatedInt32(message, &field, index);
    case FieldDescriptor::CPPTYPE_INT64:
      return static_cast<double>(one ? r.GetInt64(message, &field) : r.GetRepeatedInt64(message, &field, index));
    case FieldDescriptor::CPPTYPE_UINT32:
      return one ? r.GetUInt32(message, &field) : r.GetRepeatedUInt32(message, &field, index);
    case FieldDescriptor::CPPTYPE_UINT64:
      return static_cast<double>(one ? r.GetUInt64(message, &field) : r.GetRepeatedUInt64(message, &field, index));
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return one ? r.GetDouble(message, &field) : r.GetRepeatedDouble(message, &field, index);
    case FieldDescriptor::CPPTYPE_FLOAT:
      return one ? r.GetFloat(message, &field) : r.GetRepeatedFloat(message, &field, index);
    case FieldDescriptor::CPPTYPE_BOOL:
      return one ? r.GetBool(message, &field) : r.GetRepeatedBool(message, &field, index);
    case FieldDescriptor::CPPTYPE_ENUM:
      return one ? r.GetEnumValue(message, &field) : r.GetRepeatedEnumValue(message, &field, index);
    case FieldDescriptor::CPPTYPE_MESSAGE:
      return SecondsOf(one ? r.GetMessage(message, &field) : r.GetRepeatedMessage(message, &field, index));
    case FieldDescriptor::CPPTYPE_STRING: break;
  }
  return std::nullopt;
}

void AddPaths(const Descriptor& type, const std::string& before, std::vector<const Descriptor*>& around,
              std::size_t most, std::vector<std::string>& paths) {
  if (around.size() >= kMaxSteps || std::ranges::find(around, &type) != around.end()) return;
  around.push_back(&type);
  for (int i = 0; i < type.field_count() && paths.size() < most; ++i) {
    const FieldDescriptor& field = *type.field(i);
    const std::string path = before + field.name() + (field.is_repeated() ? "[0]" : "");
    if (IsNumber(field)) {
      paths.push_back(path);
    } else if (field.message_type() != nullptr) {
      AddPaths(*field.message_type(), path + ".", around, most, paths);
    }
  }
  around.pop_back();
}

}  // namespace

std::optional<FieldPath> FieldPath::Parse(std::string_view text, const Descriptor& type, std::string& fault) {
  FieldPath path;
  const Descriptor* in = &type;
  for (std::string_view rest = text;;) {
    const std::size_t dot = rest.find('.');
    std::string_view part = rest.substr(0, dot);
    int index = -1;
    if (const std::size_t bracket = part.find('['); bracket != std::string_view::npos) {
      const std::string_view digits = part.substr(bracket + 1);
      const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), index);
      if (error != std::errc() || index < 0 || std::string_view(end, digits.data() + digits.size()) != "]") {
        fault = "\"" + std::string(part) + "\" has no index in its brackets.";
        return std::nullopt;
      }
      part = part.substr(0, bracket);
    }
    const FieldDescriptor* const field = in->FindFieldByName(std::string(part));
    if (field == nullptr) {
      fault = in->full_name() + " has no field \"" + std::string(part) + "\".";
      return std::nullopt;
    }
    if (field->is_repeated() != (index >= 0)) {
      fault = "\"" + std::string(part) + "\" is " +
              (field->is_repeated() ? "a list: name the element, as in " : "not a list: write ") + std::string(part) +
              (field->is_repeated() ? "[0]." : ".");
      return std::nullopt;
    }
    path.steps_.push_back({field, index});
    if (dot == std::string_view::npos) {
      if (IsNumber(*field)) return path;
      fault = "\"" + std::string(text) + "\" is not a number.";
      return std::nullopt;
    }
    in = field->message_type();
    if (in == nullptr) {
      fault = "\"" + std::string(part) + "\" has no fields.";
      return std::nullopt;
    }
    rest = rest.substr(dot + 1);
  }
}

std::optional<double> FieldPath::Read(const Message& message) const {
  const Message* at = &message;
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    const auto& [field, index] = steps_[i];
    const Reflection& reflection = *at->GetReflection();
    if (index >= 0 && index >= reflection.FieldSize(*at, field)) return std::nullopt;
    if (i + 1 == steps_.size()) return ValueOf(*at, *field, index);
    if (index < 0 && !reflection.HasField(*at, field)) return std::nullopt;
    at = index < 0 ? &reflection.GetMessage(*at, field) : &reflection.GetRepeatedMessage(*at, field, index);
  }
  return std::nullopt;
}

std::vector<std::string> NumberPaths(const Descriptor& type, std::size_t most) {
  std::vector<std::string> paths;
  std::vector<const Descriptor*> around;
  AddPaths(type, {}, around, most, paths);
  return paths;
}

}  // namespace hgros::viewer
