#include "messages/message_text.hpp"

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <algorithm>
#include <charconv>
#include <type_traits>

#include "messages/known_types.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

namespace {

constexpr std::string_view kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

// One value: reads a field or one item of it.
class ScalarReader {
 private:
  template <class One, class Repeated>
  [[nodiscard]] auto Item(One one, Repeated repeated) const {
    return index_ < 0 ? (reflection_.*one)(message_, field_) : (reflection_.*repeated)(message_, field_, index_);
  }

 public:
  explicit ScalarReader(const FieldRef& place)
      : message_(*place.message), reflection_(*message_.GetReflection()), field_(place.field), index_(place.index) {}

  // Calls `take` with a bool, int64, uint64, float or double; for enums with the name of the value, or its number.
  template <class F>
  void Visit(const F& take) const {
    switch (field_->cpp_type()) {
      case FieldDescriptor::CPPTYPE_BOOL: return take(Item(&Reflection::GetBool, &Reflection::GetRepeatedBool));
      case FieldDescriptor::CPPTYPE_INT32:
        return take(std::int64_t{Item(&Reflection::GetInt32, &Reflection::GetRepeatedInt32)});
      case FieldDescriptor::CPPTYPE_INT64:
        return take(std::int64_t{Item(&Reflection::GetInt64, &Reflection::GetRepeatedInt64)});
      case FieldDescriptor::CPPTYPE_UINT32:
        return take(std::uint64_t{Item(&Reflection::GetUInt32, &Reflection::GetRepeatedUInt32)});
      case FieldDescriptor::CPPTYPE_UINT64:
        return take(std::uint64_t{Item(&Reflection::GetUInt64, &Reflection::GetRepeatedUInt64)});
      case FieldDescriptor::CPPTYPE_FLOAT: return take(Item(&Reflection::GetFloat, &Reflection::GetRepeatedFloat));
      case FieldDescriptor::CPPTYPE_DOUBLE: return take(Item(&Reflection::GetDouble, &Reflection::GetRepeatedDouble));
      case FieldDescriptor::CPPTYPE_ENUM: {
        const int number = Item(&Reflection::GetEnumValue, &Reflection::GetRepeatedEnumValue);
        const auto* value = field_->enum_type()->FindValueByNumber(number);
        return value != nullptr ? take(std::string_view(value->name())) : take(std::int64_t{number});
      }
      case FieldDescriptor::CPPTYPE_STRING:
      case FieldDescriptor::CPPTYPE_MESSAGE: return;
    }
  }
  [[nodiscard]] const std::string& Text(std::string& scratch) const {
    return index_ < 0 ? reflection_.GetStringReference(message_, field_, &scratch)
                      : reflection_.GetRepeatedStringReference(message_, field_, index_, &scratch);
  }

 private:
  const Message& message_;
  const Reflection& reflection_;
  const FieldDescriptor* field_;
  const int index_;
};

bool IsText(const FieldDescriptor& field) { return field.cpp_type() == FieldDescriptor::CPPTYPE_STRING; }
bool IsBytes(const FieldDescriptor& field) { return field.type() == FieldDescriptor::TYPE_BYTES; }

// The fields that are shown, in the order of the type: those with a value, and those that are zero without saying so.
std::vector<const FieldDescriptor*> ShownFields(const Message& message) {
  std::vector<const FieldDescriptor*> fields;
  const Descriptor& type = *message.GetDescriptor();
  for (int i = 0; i < type.field_count(); ++i) {
    const FieldDescriptor* field = type.field(i);
    if (field->is_repeated() || !field->has_presence() || message.GetReflection()->HasField(message, field)) {
      fields.push_back(field);
    }
  }
  return fields;
}

template <class T>
void AppendNumber(std::string& out, T value) {
  fmt::format_to(std::back_inserter(out), "{}", value);
}
template <>
void AppendNumber(std::string& out, bool value) {
  out += value ? "true" : "false";
}
template <>
void AppendNumber(std::string& out, std::string_view value) {
  out += value;
}
void AppendReal(std::string& out, double value, bool single) {
  if (value != value) {
    out += ".nan";
  } else if (value - value != 0) {
    out += value > 0 ? ".inf" : "-.inf";
  } else if (single) {
    fmt::format_to(std::back_inserter(out), "{}", static_cast<float>(value));
  } else {
    fmt::format_to(std::back_inserter(out), "{}", value);
  }
}
template <>
void AppendNumber(std::string& out, double value) {
  AppendReal(out, value, false);
}
template <>
void AppendNumber(std::string& out, float value) {
  AppendReal(out, value, true);
}

// Whether YAML reads the word as something else than a text.
bool IsYamlWord(std::string_view word) {
  std::string lower(word);
  std::ranges::transform(lower, lower.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  constexpr std::string_view kWords[] = {"true", "false", "null", "yes", "no", "on", "off", "y", "n"};
  return std::ranges::find(kWords, lower) != std::end(kWords);
}

// Whether YAML reads the text as this text when it is not in quotes.
bool IsPlain(std::string_view text) {
  if (text.empty() || text.size() > 60) return false;
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  const auto inside = [&](char c) { return letter(c) || (c >= '0' && c <= '9') || c == '/' || c == '.' || c == '-'; };
  return (letter(text.front()) || text.front() == '/') && std::ranges::all_of(text, inside) && !IsYamlWord(text);
}

void AppendQuoted(std::string& out, std::string_view text) {
  std::string quoted;
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  // YAML reads what Visible() writes for other characters as these characters.
  out += '"' + Visible(quoted) + '"';
}

// The beginning of `text` with whole characters.
std::string_view Beginning(std::string_view text, std::size_t most) {
  if (text.size() <= most) return text;
  while (most > 0 && (static_cast<unsigned char>(text[most]) & 0xC0U) == 0x80U) --most;
  return text.substr(0, most);
}

// One value without its line break. Returns the comment that follows it, or nothing.
std::string AppendScalar(std::string& out, const FieldRef& place, const TextLimits& limits) {
  const ScalarReader reader(place);
  if (!IsText(*place.field)) {
    reader.Visit([&out](const auto& value) {
      if constexpr (std::is_same_v<std::decay_t<decltype(value)>, std::string_view>) {
        out += NameText(value);
      } else {
        AppendNumber(out, value);
      }
    });
    return {};
  }
  std::string scratch;
  const std::string& text = reader.Text(scratch);
  if (IsBytes(*place.field)) {
    const std::size_t shown =
        std::min(text.size(), limits.characters == std::size_t(-1) ? text.size() : limits.characters / 8);
    out += "!!binary \"" + Base64(std::string_view(text).substr(0, shown)) + "\"";
    return shown == text.size() ? "" : fmt::format("  # {} of {} bytes", shown, text.size());
  }
  const std::string_view shown = Beginning(text, limits.characters);
  if (IsPlain(shown)) {
    out += shown;
  } else {
    AppendQuoted(out, shown);
  }
  return shown.size() == text.size() ? "" : fmt::format("  # {} of {} bytes", shown.size(), text.size());
}

KnownType KnownTypeOfField(const FieldDescriptor& field) {
  return field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE ? KnownTypeOf(*field.message_type()) : KnownType::kNone;
}

void AppendMessage(std::string& out, const Message& message, const TextLimits& limits, std::size_t indent);

// What follows "name:" or "-", up to and with the line break.
void AppendValue(std::string& out, const FieldRef& place, const TextLimits& limits, std::size_t indent) {
  if (const Message* message = place.AsMessage()) {
    if (const KnownType known = KnownTypeOf(*message->GetDescriptor()); known != KnownType::kNone) {
      out += " " + TextOfKnown(known, *message) + "\n";
    } else if (ShownFields(*message).empty()) {
      out += " {}\n";
    } else {
      out += "\n";
      AppendMessage(out, *message, limits, indent);
    }
    return;
  }
  out += " ";
  out += AppendScalar(out, place, limits) + "\n";
}

void AppendList(std::string& out, const FieldRef& place, const TextLimits& limits, std::size_t indent) {
  const auto size = static_cast<std::size_t>(place.message->GetReflection()->FieldSize(*place.message, place.field));
  const bool messages = place.field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE;
  const bool flow = (!messages && !IsText(*place.field)) || KnownTypeOfField(*place.field) != KnownType::kNone;
  const std::size_t most = messages ? limits.messages : limits.items;
  const std::size_t shown = size > most ? most : size;
  if (flow || size == 0) {
    out += " [";
    for (std::size_t i = 0; i < shown; ++i) {
      const FieldRef item{place.message, place.field, static_cast<int>(i)};
      if (i > 0) out += ", ";
      if (const Message* message = item.AsMessage()) {
        out += TextOfKnown(KnownTypeOfField(*place.field), *message);
      } else {
        AppendScalar(out, item, limits);
      }
    }
    out += shown < size ? fmt::format("]  # {} more\n", size - shown) : "]\n";
    return;
  }
  out += "\n";
  for (std::size_t i = 0; i < shown; ++i) {
    const FieldRef item{place.message, place.field, static_cast<int>(i)};
    const std::string before = std::string(indent, ' ') + "- ";
    if (const Message* message = item.AsMessage(); message != nullptr && !ShownFields(*message).empty()) {
      const std::size_t begin = out.size();
      AppendMessage(out, *message, limits, indent + 2);
      out.replace(begin, before.size(), before);
    } else {
      out += before.substr(0, before.size() - 1);
      AppendValue(out, item, limits, indent + 2);
    }
  }
  if (shown < size) out += std::string(indent, ' ') + fmt::format("# {} more\n", size - shown);
}

void AppendMessage(std::string& out, const Message& message, const TextLimits& limits, std::size_t indent) {
  for (const FieldDescriptor* field : ShownFields(message)) {
    const FieldRef place{&message, field, -1};
    out.append(indent, ' ');
    out += field->name();
    out += ':';
    if (place.list()) {
      AppendList(out, place, limits, indent);
    } else {
      AppendValue(out, place, limits, indent + 2);
    }
  }
}

}  // namespace

void AppendYaml(std::string& out, const FieldRef& place, const TextLimits& limits, std::size_t indent) {
  const Message* message = place.AsMessage();
  if (message != nullptr && KnownTypeOf(*message->GetDescriptor()) == KnownType::kNone) {
    if (ShownFields(*message).empty()) {
      out += std::string(indent, ' ') + "{}\n";
    } else {
      AppendMessage(out, *message, limits, indent);
    }
    return;
  }
  std::string text;
  if (place.list()) {
    AppendList(text, place, limits, indent);
  } else {
    AppendValue(text, place, limits, indent);
  }
  const bool lines = text.starts_with('\n');
  out += lines ? text.substr(1) : std::string(indent, ' ') + text.substr(1);
}

void WriteJson(Json& json, const FieldRef& place) {
  if (place.list()) {
    json.BeginList();
    const int size = place.message->GetReflection()->FieldSize(*place.message, place.field);
    for (int i = 0; i < size; ++i) WriteJson(json, {place.message, place.field, i});
    json.EndList();
  } else if (const Message* message = place.AsMessage()) {
    if (const KnownType known = KnownTypeOf(*message->GetDescriptor()); known != KnownType::kNone) {
      json.Value(TextOfKnown(known, *message));
      return;
    }
    json.BeginObject();
    for (const FieldDescriptor* field : ShownFields(*message)) {
      json.Key(field->name());
      WriteJson(json, {message, field, -1});
    }
    json.EndObject();
  } else if (IsText(*place.field)) {
    std::string scratch;
    const std::string& text = ScalarReader(place).Text(scratch);
    json.Value(IsBytes(*place.field) ? Base64(text) : text);
  } else {
    ScalarReader(place).Visit([&json](const auto& value) { json.Value(value); });
  }
}

std::string NameText(std::string_view name) {
  return IsYamlWord(name) ? '"' + std::string(name) + '"' : std::string(name);
}

std::string PlainText(const FieldRef& place) {
  const Message* message = place.AsMessage();
  if (message != nullptr && KnownTypeOf(*message->GetDescriptor()) != KnownType::kNone) {
    return TextOfKnown(KnownTypeOf(*message->GetDescriptor()), *message);
  }
  if (message != nullptr || place.list()) {
    Json json;
    WriteJson(json, place);
    return std::string(json.text());
  }
  std::string text;
  if (IsText(*place.field)) {
    std::string scratch;
    text = ScalarReader(place).Text(scratch);
    return IsBytes(*place.field) ? Base64(text) : text;
  }
  ScalarReader(place).Visit([&text](const auto& value) { AppendNumber(text, value); });
  return text;
}

std::string Base64(std::string_view bytes) {
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8U | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? kAlphabet[group >> (18 - 6 * k) & 63U] : '=';
  }
  return text;
}

bool FromBase64(std::string_view text, std::string& bytes) {
  bytes.clear();
  while (text.ends_with('=')) text.remove_suffix(1);
  std::uint32_t group = 0;
  unsigned bits = 0;
  for (const char c : text) {
    const std::size_t digit = kAlphabet.find(c);
    if (digit == std::string_view::npos) return false;
    group = group << 6U | static_cast<std::uint32_t>(digit);
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes += static_cast<char>(group >> bits & 0xFFU);
  }
  return bits < 6;
}

}  // namespace hgros::cli
