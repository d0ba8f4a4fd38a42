#include "terminal/json.hpp"

#include <fmt/format.h>

#include <cmath>

#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

const char* NameOf(double value) { return std::isnan(value) ? "NaN" : value > 0 ? "Infinity" : "-Infinity"; }

rapidjson::SizeType SizeOf(std::string_view text) { return static_cast<rapidjson::SizeType>(text.size()); }

}  // namespace

// RapidJSON escapes the control characters below U+0020; for the others the whole text is written in ASCII, which keeps
// U+007F.
void Json::WriteText(std::string_view text, bool key) {
  std::string written = ValidUtf8(text);
  if (Visible(written).size() > written.size()) {
    rapidjson::StringBuffer buffer;
    rapidjson::Writer<rapidjson::StringBuffer, rapidjson::UTF8<>, rapidjson::ASCII<>> ascii(buffer);
    ascii.String(written.data(), SizeOf(written));
    std::string escaped(buffer.GetString(), buffer.GetSize());
    for (std::size_t at = 0; (at = escaped.find('\x7f', at)) != std::string::npos;) escaped.replace(at, 1, "\\u007F");
    writer_.RawValue(escaped.data(), escaped.size(), rapidjson::kStringType);
  } else if (key) {
    writer_.Key(written.data(), SizeOf(written));
  } else {
    writer_.String(written.data(), SizeOf(written));
  }
}

Json& Json::Key(std::string_view name) {
  WriteText(name, true);
  return *this;
}

Json& Json::Value(std::string_view text) {
  WriteText(text, false);
  return *this;
}

Json& Json::Value(bool value) {
  writer_.Bool(value);
  return *this;
}

Json& Json::Value(double value) {
  if (!std::isfinite(value)) return Value(NameOf(value));
  const std::string digits = fmt::format("{}", value);
  writer_.RawValue(digits.data(), digits.size(), rapidjson::kNumberType);
  return *this;
}

Json& Json::Value(float value) {
  if (!std::isfinite(value)) return Value(NameOf(value));
  const std::string digits = fmt::format("{}", value);
  writer_.RawValue(digits.data(), digits.size(), rapidjson::kNumberType);
  return *this;
}

Json& Json::Value(std::int64_t value) {
  writer_.Int64(value);
  return *this;
}

Json& Json::Value(std::uint64_t value) {
  writer_.Uint64(value);
  return *this;
}

Json& Json::Null() {
  writer_.Null();
  return *this;
}

Json& Json::Raw(std::string_view json) {
  writer_.RawValue(json.data(), json.size(), rapidjson::kObjectType);
  return *this;
}

Json& Json::BeginObject() {
  writer_.StartObject();
  return *this;
}

Json& Json::EndObject() {
  writer_.EndObject();
  return *this;
}

Json& Json::BeginList() {
  writer_.StartArray();
  return *this;
}

Json& Json::EndList() {
  writer_.EndArray();
  return *this;
}

void Json::Clear() {
  buffer_.Clear();
  writer_.Reset(buffer_);
}

}  // namespace hgros::cli
