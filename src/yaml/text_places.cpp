#include "yaml/text_places.hpp"

#include <algorithm>

#include "hgros/base/readable_text.hpp"

namespace hgros::yaml {
namespace {

bool Continues(char c) { return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U; }

int CountCharacters(std::string_view text) {
  return static_cast<int>(std::count_if(text.begin(), text.end(), [](char c) { return !Continues(c); }));
}

bool IsControl(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return (byte < 0x20 && c != '\t' && c != '\n' && c != '\r') || byte == 0x7F;
}

}  // namespace

TextPlaces::TextPlaces(std::string_view text) : text_(text), line_starts_{0} {
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\n') line_starts_.push_back(i + 1);
  }
}

std::size_t TextPlaces::Offset(int line, int byte_column) const noexcept {
  if (line < 0 || byte_column < 0) return 0;
  if (static_cast<std::size_t>(line) >= line_starts_.size()) return text_.size();
  return std::min(line_starts_[static_cast<std::size_t>(line)] + static_cast<std::size_t>(byte_column), text_.size());
}

FilePosition TextPlaces::At(const std::string& file, int line, int byte_column) {
  if (line < 0 || byte_column < 0) return {file, 0, 0};
  line = std::min(line, static_cast<int>(line_starts_.size()) - 1);
  const std::size_t offset = Offset(line, byte_column);
  if (line != line_) {
    line_ = line;
    offset_ = Offset(line, 0);
    characters_ = 0;
  }
  if (offset >= offset_) {
    characters_ += CountCharacters(text_.substr(offset_, offset - offset_));
  } else {
    characters_ -= CountCharacters(text_.substr(offset, offset_ - offset));
  }
  offset_ = offset;
  return {file, line + 1, characters_ + 1};
}

std::string_view TextPlaces::Line(int line) const noexcept {
  if (line < 0 || static_cast<std::size_t>(line) >= line_starts_.size()) return {};
  const std::string_view rest = text_.substr(line_starts_[static_cast<std::size_t>(line)]);
  return rest.substr(0, rest.find('\n'));
}

void RequireCleanText(TextPlaces& places, const std::string& name) {
  const std::string_view text = places.text();
  int line = 0;
  std::size_t line_start = 0;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = Utf8Length(text.substr(i));
    if (length == 0 || IsControl(text[i])) {
      constexpr std::string_view kDigits = "0123456789abcdef";
      const auto byte = static_cast<unsigned char>(text[i]);
      const std::string code = {'0', 'x', kDigits[byte >> 4U], kDigits[byte & 15U]};
      const FilePosition position = places.At(name, line, static_cast<int>(i - line_start));
      if (length == 0)
        throw ConfigError("The byte " + code + " is not UTF-8 text.", position, "Save the file as UTF-8.");
      throw ConfigError("The control character " + code + " is not allowed in YAML.", position,
                        "Remove it, or write it as an escape in double quotes.");
    }
    if (text[i] == '\n') {
      ++line;
      line_start = i + 1;
    }
    i += length;
  }
}

}  // namespace hgros::yaml
