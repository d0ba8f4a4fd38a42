#include "params/yaml_writing.hpp"

#include <algorithm>
#include <string_view>

#include "hgros/base/readable_text.hpp"
#include "hgros/yaml/scalar_text.hpp"

namespace hgros::yaml_writing {
namespace {

// In double quotes, with the escapes that YAML knows. What Readable() escapes has such escapes.
std::string Quoted(std::string_view text) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string quoted = "\"";
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (const std::size_t length = Utf8Length(text.substr(i)); length > 1) {
      quoted += Readable(text.substr(i, length));
      i += length - 1;
      continue;
    }
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += {'\\', c};
    } else if (c == '\n') {
      quoted += "\\n";
    } else if (c == '\t') {
      quoted += "\\t";
    } else if (byte < 0x20 || byte == 0x7F) {
      quoted += {'\\', 'x', kDigits[byte >> 4U], kDigits[byte & 15U]};
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

// Safe without quotes wherever it stands.
bool IsWord(std::string_view text) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  const auto inner = [&](char c) { return letter(c) || (c >= '0' && c <= '9') || c == '-' || c == '.' || c == '/'; };
  return !text.empty() && letter(text[0]) && std::all_of(text.begin(), text.end(), inner) &&
         scalar::IsPlainString(text);
}

}  // namespace

std::string Key(const std::string& key) { return IsWord(key) ? key : Quoted(key); }

std::string Inline(const ParamNode& node) {
  std::string text;
  switch (node.kind) {
    case ParamNode::Kind::kNull: return "~";
    case ParamNode::Kind::kText:
      if (!node.IsString()) return node.text;
      return IsWord(node.text) ? node.text : Quoted(node.text);
    case ParamNode::Kind::kList:
      for (const ParamNodePtr& item : node.items) text += (text.empty() ? "" : ", ") + Inline(*item);
      return "[" + text + "]";
    case ParamNode::Kind::kMap: break;
  }
  for (const auto& [key, value] : node.entries) text += (text.empty() ? "" : ", ") + Key(key) + ": " + Inline(*value);
  return "{" + text + "}";
}

std::string Entry(const std::string& key, const ParamNode& value, int indent) {
  const std::string head = std::string(static_cast<std::size_t>(indent), ' ') + Key(key) + ":";
  if (value.kind != ParamNode::Kind::kMap || value.entries.empty()) return head + " " + Inline(value) + "\n";
  return head + "\n" + Entries(value, indent + 2);
}

std::string Entries(const ParamNode& map, int indent) {
  std::string text;
  for (const auto& [key, value] : map.entries) text += Entry(key, *value, indent);
  return text;
}

}  // namespace hgros::yaml_writing
