#include "terminal/visible_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cwchar>

namespace hgros::cli {
namespace {

// The length of the character that begins `text`, and its code point; 0 if it is not UTF-8.
struct Character {
  std::size_t bytes = 0;
  std::uint32_t code = 0;
};

bool Continues(char byte) { return (static_cast<unsigned char>(byte) & 0xC0U) == 0x80U; }

Character FirstOf(std::string_view text) {
  const auto lead = static_cast<unsigned char>(text.front());
  if (lead < 0x80) return {1, lead};
  const std::size_t length = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  constexpr std::uint32_t kSmallest[] = {0, 0, 0x80, 0x800, 0x10000};
  if (lead < 0xC2 || lead > 0xF4 || text.size() < length) return {};
  std::uint32_t code = lead & (0x7FU >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if (!Continues(text[i])) return {};
    code = code << 6U | (static_cast<unsigned char>(text[i]) & 0x3FU);
  }
  if (code < kSmallest[length] || code > 0x10FFFF || (code >= 0xD800 && code <= 0xDFFF)) return {};
  return {length, code};
}

bool IsShown(std::uint32_t code) {
  if (code < 0x20 || (code >= 0x7F && code <= 0x9F)) return false;
  // Marks that change the direction of text, and separators of lines and paragraphs.
  return !(code == 0x061C || code == 0x200E || code == 0x200F || (code >= 0x2028 && code <= 0x202E) ||
           (code >= 0x2066 && code <= 0x2069) || code == 0xFEFF);
}

// Takes the first character from visible text. Returns its columns.
std::size_t TakeCharacter(std::string_view& visible) noexcept {
  const Character first = FirstOf(visible);
  visible.remove_prefix(std::max<std::size_t>(first.bytes, 1));
  const int width = first.code < 0x80 ? 1 : wcwidth(static_cast<wchar_t>(first.code));  // -1: the locale has none.
  return width < 0 ? 1 : static_cast<std::size_t>(width);
}

}  // namespace

std::string Visible(std::string_view text) {
  const auto plain = [](char c) { return c >= 0x20 && c < 0x7F; };
  if (std::ranges::all_of(text, plain)) return std::string(text);
  std::string shown;
  shown.reserve(text.size() + 8);
  while (!text.empty()) {
    const Character first = FirstOf(text);
    if (first.bytes == 0) {
      fmt::format_to(std::back_inserter(shown), "\\x{:02x}", static_cast<unsigned char>(text.front()));
    } else if (IsShown(first.code)) {
      shown += text.substr(0, first.bytes);
    } else if (first.code == '\n') {
      shown += "\\n";
    } else if (first.code == '\t') {
      shown += "\\t";
    } else if (first.code == '\r') {
      shown += "\\r";
    } else if (first.code < 0x100) {
      fmt::format_to(std::back_inserter(shown), "\\x{:02x}", first.code);
    } else {
      fmt::format_to(std::back_inserter(shown), "\\u{:04x}", first.code);
    }
    text.remove_prefix(std::max<std::size_t>(first.bytes, 1));
  }
  return shown;
}

std::string VisibleLines(std::string_view text) {
  std::string visible;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    visible += Visible(text.substr(0, end));
    if (end == std::string_view::npos) break;
    visible += '\n';
    text.remove_prefix(end + 1);
  }
  return visible;
}

std::string ValidUtf8(std::string_view text) {
  const auto ascii = [](char c) { return static_cast<unsigned char>(c) < 0x80; };
  if (std::ranges::all_of(text, ascii)) return std::string(text);
  std::string valid;
  valid.reserve(text.size() + 8);
  while (!text.empty()) {
    const Character first = FirstOf(text);
    valid += first.bytes == 0 ? std::string_view("\xEF\xBF\xBD") : text.substr(0, first.bytes);
    text.remove_prefix(std::max<std::size_t>(first.bytes, 1));
  }
  return valid;
}

std::size_t ColumnsOf(std::string_view visible) noexcept {
  std::size_t columns = 0;
  while (!visible.empty()) columns += TakeCharacter(visible);
  return columns;
}

std::string_view FirstColumns(std::string_view visible, std::size_t columns) noexcept {
  std::string_view rest = visible;
  for (std::string_view next = rest; !rest.empty(); rest = next) {
    const std::size_t width = TakeCharacter(next);
    if (width > columns) break;
    columns -= width;
  }
  return visible.substr(0, visible.size() - rest.size());
}

std::string Shortened(std::string_view visible, std::size_t columns) {
  constexpr std::string_view kDots = "...";
  // No character takes less than a byte for each of its columns.
  if (visible.size() <= columns || FirstColumns(visible, columns).size() == visible.size()) return std::string(visible);
  if (columns <= kDots.size()) return std::string(FirstColumns(visible, columns));
  return std::string(FirstColumns(visible, columns - kDots.size())) + std::string(kDots);
}

}  // namespace hgros::cli
