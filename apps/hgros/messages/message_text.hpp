#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "messages/field_path.hpp"
#include "terminal/json.hpp"

namespace hgros::cli {

/// How much of long lists, texts and bytes is shown. The rest is counted in a comment.
struct TextLimits {
  std::size_t items = 16;
  std::size_t messages = 8;
  std::size_t characters = 400;

  [[nodiscard]] static constexpr TextLimits None() { return {std::size_t(-1), std::size_t(-1), std::size_t(-1)}; }
};

/// Appends what is at `place` as YAML, each line after `indent` spaces and with a line break at its end. Fields without
/// a value that protobuf knows are shown as zero; messages that are not set are left out. Texts are visible, bytes
/// base64.
void AppendYaml(std::string& out, const FieldRef& place, const TextLimits& limits, std::size_t indent = 0);

/// The same as JSON, complete. 64-bit integers are numbers; bytes are base64.
void WriteJson(Json& json, const FieldRef& place);

/// A single value as text: a number, a text without quotes, the name of an enum's value. JSON for anything else.
[[nodiscard]] std::string PlainText(const FieldRef& place);

/// The name of an enum's value as YAML: in quotes if YAML reads it as a boolean, such as OFF.
[[nodiscard]] std::string NameText(std::string_view name);

[[nodiscard]] std::string Base64(std::string_view bytes);
/// Empty and false if `text` is not base64.
[[nodiscard]] bool FromBase64(std::string_view text, std::string& bytes);

}  // namespace hgros::cli
