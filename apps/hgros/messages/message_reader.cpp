#include "messages/message_reader.hpp"

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "arguments/arguments.hpp"
#include "hgros/base/names.hpp"
#include "messages/field_path.hpp"
#include "messages/known_types.hpp"
#include "messages/message_text.hpp"

namespace hgros::cli {

using google::protobuf::Descriptor;
using google::protobuf::EnumDescriptor;
using google::protobuf::EnumValueDescriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::OneofDescriptor;
using google::protobuf::Reflection;
using yaml::Node;

namespace {

// A part of the user's text for an error.
std::string Excerpt(const std::string& text) {
  constexpr std::size_t kMost = 60;
  std::size_t end = std::min(text.size(), kMost);
  while (end < text.size() && end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
  return "\"" + text.substr(0, end) + (end < text.size() ? "...\"" : "\"");
}

template <class T>
std::string NameOfWhole() {
  return fmt::format("{}int{}", std::is_unsigned_v<T> ? "u" : "", sizeof(T) * 8);
}

// What one value of the field must be.
std::string Wanted(const FieldDescriptor& field) {
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_BOOL: return "true or false";
    case FieldDescriptor::CPPTYPE_INT32:
    case FieldDescriptor::CPPTYPE_INT64:
    case FieldDescriptor::CPPTYPE_UINT32:
    case FieldDescriptor::CPPTYPE_UINT64: return "a whole number";
    case FieldDescriptor::CPPTYPE_FLOAT:
    case FieldDescriptor::CPPTYPE_DOUBLE: return "a number";
    case FieldDescriptor::CPPTYPE_ENUM: return "a value of " + field.enum_type()->full_name();
    case FieldDescriptor::CPPTYPE_STRING: return field.type() == FieldDescriptor::TYPE_BYTES ? "base64" : "a text";
    case FieldDescriptor::CPPTYPE_MESSAGE: break;
  }
  switch (KnownTypeOf(*field.message_type())) {
    case KnownType::kTimestamp: return R"(a time such as "2026-11-23T11:50:33.25Z", "now" or seconds)";
    case KnownType::kDuration: return R"(a duration such as "1.5s")";
    case KnownType::kNone: break;
  }
  return "a map of the fields of " + field.message_type()->full_name();
}

// Sets a field, or adds to a list.
class FieldWriter {
 public:
  FieldWriter(Message& message, const FieldDescriptor& field)
      : message_(message), reflection_(*message.GetReflection()), field_(field) {}

  void Put(std::int32_t value) { Put(value, &Reflection::SetInt32, &Reflection::AddInt32); }
  void Put(std::int64_t value) { Put(value, &Reflection::SetInt64, &Reflection::AddInt64); }
  void Put(std::uint32_t value) { Put(value, &Reflection::SetUInt32, &Reflection::AddUInt32); }
  void Put(std::uint64_t value) { Put(value, &Reflection::SetUInt64, &Reflection::AddUInt64); }
  void Put(float value) { Put(value, &Reflection::SetFloat, &Reflection::AddFloat); }
  void Put(double value) { Put(value, &Reflection::SetDouble, &Reflection::AddDouble); }
  void Put(bool value) { Put(value, &Reflection::SetBool, &Reflection::AddBool); }
  void PutEnum(int value) { Put(value, &Reflection::SetEnumValue, &Reflection::AddEnumValue); }
  void Put(std::string value) {
    if (field_.is_repeated()) {
      reflection_.AddString(&message_, &field_, std::move(value));
    } else {
      reflection_.SetString(&message_, &field_, std::move(value));
    }
  }
  Message& PutMessage() {
    return *(field_.is_repeated() ? reflection_.AddMessage(&message_, &field_)
                                  : reflection_.MutableMessage(&message_, &field_));
  }

 private:
  template <class T, class Set, class Add>
  void Put(T value, Set set, Add add) {
    (reflection_.*(field_.is_repeated() ? add : set))(&message_, &field_, value);
  }

  Message& message_;
  const Reflection& reflection_;
  const FieldDescriptor& field_;
};

class MessageReader {
 public:
  explicit MessageReader(const MessageDocument& document) : document_(document) {}

  void ReadFields(const Node& value, Message& message);

 private:
  [[noreturn]] void Fail(const Node& node, const std::string& what, const std::string& mend = {}) const {
    throw ConfigError(what, document_.PositionOf(node), mend);
  }
  [[noreturn]] void FailWanted(const Node& node, const FieldDescriptor& field) const {
    const char* given = node.kind == Node::Kind::kList   ? "a list"
                        : node.kind == Node::Kind::kMap  ? "a map"
                        : node.kind == Node::Kind::kNull ? "nothing"
                                                         : nullptr;
    const std::string is = given != nullptr ? given : Excerpt(node.text) + (node.quoted ? " in quotes" : "");
    Fail(node, field.name() + " must be " + Wanted(field) + ", and not " + is + ".");
  }
  void ReadField(const Node& value, Message& message, const FieldDescriptor& field);
  void ReadEntries(const Node& map, Message& message, const FieldDescriptor& field);
  // `key`: of a map; JSON writes all of them in quotes.
  void ReadOne(const Node& value, Message& message, const FieldDescriptor& field, bool key = false);
  void ReadNested(const Node& value, FieldWriter& writer, const FieldDescriptor& field);
  void ReadTime(const Node& value, KnownType known, Message& message, const FieldDescriptor& field);
  [[nodiscard]] int EnumNumber(const Node& value, const FieldDescriptor& field) const;
  template <class T>
  [[nodiscard]] T Whole(const Node& value, const FieldDescriptor& field, bool key) const;
  template <class T>
  [[nodiscard]] T Real(const Node& value, const FieldDescriptor& field) const;

  const MessageDocument& document_;
};

void MessageReader::ReadFields(const Node& value, Message& message) {
  if (value.kind == Node::Kind::kNull) return;
  const Descriptor& type = *message.GetDescriptor();
  if (value.kind != Node::Kind::kMap) {
    Fail(value, "A message of " + type.full_name() + " is a map of its fields.", "Write {field: value}.");
  }
  std::set<const FieldDescriptor*> seen;
  std::set<const OneofDescriptor*> chosen;
  for (const Node::Entry& entry : value.entries) {
    const FieldDescriptor* field = nullptr;
    try {
      field = &RequireField(type, entry.key->text);
    } catch (const UsageError& error) {
      Fail(*entry.key, error.what());
    }
    if (!seen.insert(field).second) Fail(*entry.key, "The field " + field->name() + " is given twice.");
    if (entry.value->kind == Node::Kind::kNull) continue;
    const OneofDescriptor* oneof = field->containing_oneof();
    if (oneof != nullptr && !chosen.insert(oneof).second) {
      Fail(*entry.key, "Only one field of " + oneof->name() + " can be set, and " + field->name() + " is the second.");
    }
    ReadField(*entry.value, message, *field);
  }
}

void MessageReader::ReadField(const Node& value, Message& message, const FieldDescriptor& field) {
  if (!field.is_repeated()) return ReadOne(value, message, field);
  if (value.kind == Node::Kind::kMap && IsMapField(field)) return ReadEntries(value, message, field);
  if (value.kind != Node::Kind::kList) {
    const bool map = IsMapField(field);
    Fail(value, field.name() + " is a " + (map ? "map" : "list") + ".",
         map ? "Write {key: value}." : "Write its items in brackets: [..., ...].");
  }
  for (const Node* item : value.items) ReadOne(*item, message, field);
}

void MessageReader::ReadEntries(const Node& map, Message& message, const FieldDescriptor& field) {
  const Descriptor& type = *field.message_type();
  for (const Node::Entry& entry : map.entries) {
    Message& added = FieldWriter(message, field).PutMessage();
    ReadOne(*entry.key, added, *type.FindFieldByNumber(1), true);
    if (entry.value->kind != Node::Kind::kNull) ReadOne(*entry.value, added, *type.FindFieldByNumber(2));
  }
}

void MessageReader::ReadOne(const Node& value, Message& message, const FieldDescriptor& field, bool key) {
  FieldWriter writer(message, field);
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) return ReadNested(value, writer, field);
  if (value.kind != Node::Kind::kText) FailWanted(value, field);
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_BOOL:
      if ((value.quoted && !key) || (value.text != "true" && value.text != "false")) FailWanted(value, field);
      return writer.Put(value.text == "true");
    case FieldDescriptor::CPPTYPE_INT32: return writer.Put(Whole<std::int32_t>(value, field, key));
    case FieldDescriptor::CPPTYPE_INT64: return writer.Put(Whole<std::int64_t>(value, field, key));
    case FieldDescriptor::CPPTYPE_UINT32: return writer.Put(Whole<std::uint32_t>(value, field, key));
    case FieldDescriptor::CPPTYPE_UINT64: return writer.Put(Whole<std::uint64_t>(value, field, key));
    case FieldDescriptor::CPPTYPE_FLOAT: return writer.Put(Real<float>(value, field));
    case FieldDescriptor::CPPTYPE_DOUBLE: return writer.Put(Real<double>(value, field));
    case FieldDescriptor::CPPTYPE_ENUM: return writer.PutEnum(EnumNumber(value, field));
    default: break;
  }
  if (field.type() != FieldDescriptor::TYPE_BYTES) return writer.Put(value.text);
  std::string text = value.text;
  std::erase_if(text, [](char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; });
  std::string bytes;
  if (!FromBase64(text, bytes)) FailWanted(value, field);
  writer.Put(std::move(bytes));
}

void MessageReader::ReadNested(const Node& value, FieldWriter& writer, const FieldDescriptor& field) {
  const KnownType known = KnownTypeOf(*field.message_type());
  if (value.kind == Node::Kind::kText && known != KnownType::kNone) {
    return ReadTime(value, known, writer.PutMessage(), field);
  }
  if (value.kind != Node::Kind::kMap) FailWanted(value, field);
  ReadFields(value, writer.PutMessage());
}

void MessageReader::ReadTime(const Node& value, KnownType known, Message& message, const FieldDescriptor& field) {
  const std::optional<SecondsAndNanos> time = ReadKnown(known, value.text);
  if (!time) FailWanted(value, field);
  const Reflection& reflection = *message.GetReflection();
  const Descriptor& type = *message.GetDescriptor();
  reflection.SetInt64(&message, type.FindFieldByName("seconds"), time->seconds);
  reflection.SetInt32(&message, type.FindFieldByName("nanos"), time->nanos);
}

int MessageReader::EnumNumber(const Node& value, const FieldDescriptor& field) const {
  const EnumDescriptor& type = *field.enum_type();
  if (const EnumValueDescriptor* named = type.FindValueByName(value.text)) return named->number();
  if (!value.quoted && value.text.find_first_not_of("+-0123456789") == std::string::npos) {
    return Whole<std::int32_t>(value, field, false);
  }
  std::vector<std::string> names;
  std::string all;
  for (int i = 0; i < type.value_count(); ++i) {
    names.push_back(type.value(i)->name());
    if (i < 20) all += (all.empty() ? "" : ", ") + names.back();
  }
  if (names.size() > 20) all += ", ...";
  std::string upper = value.text;
  std::ranges::transform(upper, upper.begin(),
                         [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 32) : c; });
  const std::string nearest = value.text.size() > 100 ? std::string() : NearestName(upper, names);
  Fail(value, Excerpt(value.text) + " is not a value of " + type.full_name() + ".",
       nearest.empty() ? "It has: " + all + "." : "Did you mean " + nearest + "?");
}

template <class T>
T MessageReader::Whole(const Node& value, const FieldDescriptor& field, bool key) const {
  // Programs write 64-bit numbers of JSON in quotes, because JavaScript cannot hold them.
  if (value.quoted && !key && sizeof(T) < 8) FailWanted(value, field);
  std::string_view digits = value.text;
  if (digits.starts_with('+') && digits.size() > 1 && digits[1] != '-') digits.remove_prefix(1);
  const bool hexadecimal = digits.starts_with("0x");
  if (hexadecimal) digits.remove_prefix(2);
  const bool negative = digits.starts_with('-');
  const std::string_view positive = negative ? digits.substr(1) : digits;
  const char* allowed = hexadecimal ? "0123456789abcdefABCDEF" : "0123456789";
  if (positive.empty() || positive.find_first_not_of(allowed) != std::string_view::npos || (hexadecimal && negative)) {
    FailWanted(value, field);
  }
  T number{};
  const auto [stopped, error] =
      std::from_chars(digits.data(), digits.data() + digits.size(), number, hexadecimal ? 16 : 10);
  if (error == std::errc() && stopped == digits.data() + digits.size()) return number;
  Fail(value,
       fmt::format("{} is out of range for {}, which is {} and goes from {} to {}.", Excerpt(value.text), field.name(),
                   NameOfWhole<T>(), std::numeric_limits<T>::min(), std::numeric_limits<T>::max()));
}

template <class T>
T MessageReader::Real(const Node& value, const FieldDescriptor& field) const {
  std::string_view text = value.text;
  const bool negative = text.starts_with('-');
  if (negative || text.starts_with('+')) text.remove_prefix(1);
  const T sign = negative ? T{-1} : T{1};
  for (const std::string_view word : {".inf", ".Inf", ".INF", "Infinity", "inf"}) {
    if (text == word) return sign * std::numeric_limits<T>::infinity();
  }
  for (const std::string_view word : {".nan", ".NaN", ".NAN", "NaN", "nan"}) {
    if (text == word) return std::numeric_limits<T>::quiet_NaN();
  }
  if (value.quoted || text.empty() || text.find_first_not_of("0123456789.eE+-") != std::string_view::npos ||
      text.front() == '-' || text.front() == '+') {
    FailWanted(value, field);
  }
  const char* end = text.data() + text.size();
  T number{};
  const auto [stopped, error] = std::from_chars(text.data(), end, number);
  if (stopped != end || error == std::errc::invalid_argument) FailWanted(value, field);
  if (error == std::errc()) return sign * number;
  // Too large, or so small that it is zero: a value that from_chars does not tell.
  const double rough = std::strtod(std::string(text).c_str(), nullptr);
  if (rough < 1) return sign * static_cast<T>(rough);
  Fail(value, fmt::format("{} is too large for {}, which is a {}.", Excerpt(value.text), field.name(),
                          sizeof(T) == 4 ? "float" : "double"));
}

}  // namespace

void ReadMessage(const MessageDocument& document, const Node& value, Message& message) {
  MessageReader(document).ReadFields(value, message);
}

bool IsMapField(const FieldDescriptor& field) {
  if (!field.is_repeated() || field.cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) return false;
  if (field.is_map()) return true;
  const Descriptor& entry = *field.message_type();
  if (entry.containing_type() != field.containing_type() || entry.field_count() != 2) return false;
  std::string camel;
  bool upper = true;
  for (const char c : field.name()) {
    if (c != '_') camel += upper && c >= 'a' && c <= 'z' ? static_cast<char>(c - 32) : c;
    upper = c == '_';
  }
  const FieldDescriptor* key = entry.FindFieldByNumber(1);
  const FieldDescriptor* value = entry.FindFieldByNumber(2);
  return entry.name() == camel + "Entry" && key != nullptr && value != nullptr && key->name() == "key" &&
         value->name() == "value" && !key->is_repeated() && !value->is_repeated() &&
         key->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE;
}

}  // namespace hgros::cli
