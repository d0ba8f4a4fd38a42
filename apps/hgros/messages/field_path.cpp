#include "messages/field_path.hpp"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <charconv>
#include <string>

#include "arguments/arguments.hpp"
#include "hgros/base/names.hpp"

namespace hgros::cli {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

bool FieldRef::list() const noexcept { return field != nullptr && field->is_repeated() && index < 0; }

const Message* FieldRef::AsMessage() const {
  if (field == nullptr) return message;
  if (list() || field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) return nullptr;
  const google::protobuf::Reflection& reflection = *message->GetReflection();
  return index < 0 ? &reflection.GetMessage(*message, field) : &reflection.GetRepeatedMessage(*message, field, index);
}

const FieldDescriptor& RequireField(const Descriptor& type, std::string_view name) {
  const FieldDescriptor* field = type.FindFieldByName(std::string(name));
  if (field != nullptr) return *field;
  std::vector<std::string> names;
  for (int i = 0; i < type.field_count(); ++i) names.push_back(type.field(i)->name());
  const std::string nearest = NearestName(name, names);
  std::string all;
  for (const std::string& one : names) all += (all.empty() ? "" : ", ") + one;
  throw UsageError(type.full_name() + " has no field \"" + std::string(name) + "\". " +
                   (nearest.empty() ? "It has: " + all + "." : "Did you mean " + nearest + "?"));
}

namespace {

// Removes the first part, up to a dot, from `text`.
std::string_view TakePart(std::string_view& text) {
  const std::size_t end = text.find('.');
  const std::string_view part = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  if (end != std::string_view::npos && text.empty()) throw UsageError("A field path must not end with a dot.");
  return part;
}

// Removes the index from "ranges[0]"; -1: there is none.
int TakeIndex(std::string_view& part) {
  const std::size_t bracket = part.find('[');
  if (bracket == std::string_view::npos) return -1;
  int index = -1;
  const std::string_view digits = part.substr(bracket + 1, part.size() - bracket - 2);
  const auto [stopped, error] = std::from_chars(digits.data(), digits.data() + digits.size(), index);
  const bool too_large = error == std::errc::result_out_of_range;
  if (!part.ends_with(']') || (error != std::errc() && !too_large) || stopped != digits.data() + digits.size() ||
      index < (too_large ? -1 : 0)) {
    throw UsageError("\"" + std::string(part) + "\" is not a field with an index. Write it as ranges[0].");
  }
  if (too_large)
    throw UsageError("The index in \"" + std::string(part) + "\" is too large. At most 2147483647 is possible.");
  part = part.substr(0, bracket);
  return index;
}

}  // namespace

void FieldPath::RequireForm(std::string_view text) {
  while (!text.empty()) {
    std::string_view part = TakePart(text);
    (void)TakeIndex(part);
  }
}

FieldPath FieldPath::Parse(std::string_view text, const Descriptor& type) {
  FieldPath path;
  const Descriptor* at = &type;
  while (!text.empty()) {
    std::string_view part = TakePart(text);
    const int index = TakeIndex(part);
    if (at == nullptr) {
      throw UsageError("\"" + path.steps_.back().field->name() + "\" has no fields, so it has no \"" +
                       std::string(part) + "\".");
    }
    const FieldDescriptor& field = RequireField(*at, part);
    if (index >= 0 && !field.is_repeated())
      throw UsageError("\"" + field.name() + "\" is not a list, so it has no index.");
    if (!text.empty() && field.is_repeated() && index < 0) {
      throw UsageError("\"" + field.name() + "\" is a list. Write which of its items is meant, such as " +
                       field.name() + "[0]." + std::string(text) + ".");
    }
    path.steps_.push_back({&field, index});
    at = field.message_type();
  }
  return path;
}

std::optional<FieldRef> FieldPath::Find(const Message& message) const {
  FieldRef at{&message, nullptr, -1};
  for (const Step& step : steps_) {
    if (at.field != nullptr) at.message = at.AsMessage();
    at.field = step.field;
    at.index = step.index;
    const google::protobuf::Reflection& reflection = *at.message->GetReflection();
    if (step.index >= 0 && step.index >= reflection.FieldSize(*at.message, step.field)) return std::nullopt;
    if (!step.field->is_repeated() && step.field->has_presence() && !reflection.HasField(*at.message, step.field)) {
      return std::nullopt;
    }
  }
  return at;
}

const FieldDescriptor* FieldPath::field() const noexcept { return steps_.empty() ? nullptr : steps_.back().field; }

bool FieldPath::list() const noexcept {
  return !steps_.empty() && steps_.back().field->is_repeated() && steps_.back().index < 0;
}

}  // namespace hgros::cli
