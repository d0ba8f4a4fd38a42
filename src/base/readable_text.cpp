#include "hgros/base/readable_text.hpp"

#include <array>
#include <cstdint>
#include <cstdio>

namespace hgros {
namespace {

// The code point of a UTF-8 character of `length` bytes.
std::uint32_t CodePoint(std::string_view character, std::size_t length) {
  constexpr std::array<unsigned, 5> kFirstBits{0, 0x7f, 0x1f, 0x0f, 0x07};
  std::uint32_t code = static_cast<unsigned char>(character[0]) & kFirstBits[length];
  for (std::size_t i = 1; i < length; ++i) code = code << 6U | (static_cast<unsigned char>(character[i]) & 0x3fU);
  return code;
}

bool IsReadable(std::uint32_t code) {
  const bool control = code < 0x20 || (code >= 0x7f && code < 0xa0);
  // Separators of lines and paragraphs, and what changes the direction of text.
  const bool layout = (code >= 0x2028 && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069);
  return !control && !layout;
}

std::string Escaped(std::uint32_t code) {
  if (code == '\n') return "\\n";
  if (code == '\r') return "\\r";
  if (code == '\t') return "\\t";
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), code < 0x80 ? "\\x%02x" : "\\u%04x", static_cast<unsigned>(code));
  return text.data();
}

}  // namespace

std::size_t Utf8Length(std::string_view text) noexcept {
  const auto byte = [&](std::size_t i) -> unsigned {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0;
  };
  const auto continues = [&](std::size_t i) { return (byte(i) & 0xc0U) == 0x80U; };
  if (text.empty()) return 0;
  const unsigned first = byte(0);
  if (first < 0x80) return 1;
  if (first < 0xc2) return 0;
  if (first < 0xe0) return continues(1) ? 2 : 0;
  const unsigned second = byte(1);
  if (first < 0xf0) {
    const bool refused = (first == 0xe0 && second < 0xa0) || (first == 0xed && second > 0x9f);
    return continues(1) && continues(2) && !refused ? 3 : 0;
  }
  const bool refused = (first == 0xf0 && second < 0x90) || (first == 0xf4 && second > 0x8f) || first > 0xf4;
  return continues(1) && continues(2) && continues(3) && !refused ? 4 : 0;
}

bool IsUtf8(std::string_view text) noexcept {
  while (!text.empty()) {
    const std::size_t length = static_cast<signed char>(text.front()) >= 0 ? 1 : Utf8Length(text);
    if (length == 0) return false;
    text.remove_prefix(length);
  }
  return true;
}

std::string AsUtf8(std::string_view text) { return IsUtf8(text) ? std::string(text) : Readable(text); }

bool IsReadable(std::string_view text) noexcept {
  while (!text.empty()) {
    const std::size_t length = Utf8Length(text);
    if (length == 0 || !IsReadable(CodePoint(text, length))) return false;
    text.remove_prefix(length);
  }
  return true;
}

std::string Readable(std::string_view text, std::size_t most_bytes) {
  std::string readable;
  while (!text.empty()) {
    const std::size_t length = Utf8Length(text);
    std::string shown;
    if (length == 0) {
      std::array<char, 8> byte{};
      std::snprintf(byte.data(), byte.size(), "\\x%02x", static_cast<unsigned>(static_cast<unsigned char>(text[0])));
      shown = byte.data();
    } else if (const std::uint32_t code = CodePoint(text, length); IsReadable(code)) {
      shown = text.substr(0, length);
    } else {
      shown = Escaped(code);
    }
    if (shown.size() > most_bytes - readable.size()) break;
    readable += shown;
    text.remove_prefix(length == 0 ? 1 : length);
  }
  return readable;
}

}  // namespace hgros
