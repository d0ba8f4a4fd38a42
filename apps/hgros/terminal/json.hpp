#pragma once

#include <rapidjson/stringbuffer.h>
#include <rapidjson/writer.h>

#include <cstdint>
#include <string>
#include <string_view>

namespace hgros::cli {

/// Writes one JSON value into a text. Numbers that JSON does not have (NaN, infinity) become the strings "NaN",
/// "Infinity" and "-Infinity"; bytes of a string that are not UTF-8 become U+FFFD, and
/// characters that a terminal would obey are escaped.
class Json {
 public:
  Json& Key(std::string_view name);
  Json& Value(std::string_view text);
  Json& Value(const char* text) { return Value(std::string_view(text)); }
  Json& Value(const std::string& text) { return Value(std::string_view(text)); }
  Json& Value(bool value);
  Json& Value(double value);
  Json& Value(float value);  ///< With the digits that a float has.
  Json& Value(std::int64_t value);
  Json& Value(std::uint64_t value);
  Json& Value(int value) { return Value(static_cast<std::int64_t>(value)); }
  Json& Null();
  Json& Raw(std::string_view json);  ///< A value that is JSON already.
  Json& BeginObject();
  Json& EndObject();
  Json& BeginList();
  Json& EndList();
  template <class T>
  Json& Member(std::string_view name, const T& value) {
    return Key(name).Value(value);
  }

  [[nodiscard]] std::string_view text() const { return {buffer_.GetString(), buffer_.GetSize()}; }
  void Clear();

 private:
  void WriteText(std::string_view text, bool key);

  rapidjson::StringBuffer buffer_;
  rapidjson::Writer<rapidjson::StringBuffer> writer_{buffer_};
};

}  // namespace hgros::cli
