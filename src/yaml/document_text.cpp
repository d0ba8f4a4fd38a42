// A document as text, from which the same document is read.
#include <algorithm>
#include <array>
#include <string_view>

#include "hgros/yaml/document.hpp"

namespace hgros::yaml {
namespace {

bool IsLetterOrDigit(char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

// Whether it may be a number or a boolean, and is nothing else without quotes.
bool IsPlain(const Node& node) {
  constexpr std::array<std::string_view, 3> kNulls{"null", "Null", "NULL"};
  return !node.quoted && std::ranges::any_of(node.text, IsLetterOrDigit) &&
         std::ranges::find(kNulls, node.text) == kNulls.end() && std::ranges::all_of(node.text, [](char c) {
           return IsLetterOrDigit(c) || std::string_view("+-._").find(c) != std::string_view::npos;
         });
}

void WriteQuoted(std::string_view text, std::string& to) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  const auto escape = [&](unsigned char code) {
    to += "\\x";
    to += kDigits[code >> 4U];
    to += kDigits[code & 15U];
  };
  to += '"';
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const auto next = static_cast<unsigned char>(i + 1 < text.size() ? text[i + 1] : 0);
    if (byte == '"' || byte == '\\') {
      to += '\\';
      to += text[i];
    } else if (byte < 0x20 || byte == 0x7f) {
      escape(byte);
    } else if (byte == 0xc2 && next < 0xa0) {  // A control character of Latin-1.
      escape(next);
      ++i;
    } else {
      to += text[i];
    }
  }
  to += '"';
}

void Write(const Node& node, std::string& to) {
  bool first = true;
  const auto separate = [&] {
    if (!first) to += ", ";
    first = false;
  };
  switch (node.kind) {
    case Node::Kind::kNull: to += "null"; return;
    case Node::Kind::kText:
      if (IsPlain(node)) {
        to += node.text;
      } else {
        WriteQuoted(node.text, to);
      }
      return;
    case Node::Kind::kList:
      to += '[';
      for (const Node* item : node.items) {
        separate();
        Write(*item, to);
      }
      to += ']';
      return;
    case Node::Kind::kMap:
      to += '{';
      for (const auto& [key, value] : node.entries) {
        separate();
        WriteQuoted(key->text, to);
        to += ": ";
        Write(*value, to);
      }
      to += '}';
      return;
  }
}

}  // namespace

std::string Document::ToYaml() const {
  std::string text;
  Write(*root_, text);
  return text + "\n";
}

}  // namespace hgros::yaml
