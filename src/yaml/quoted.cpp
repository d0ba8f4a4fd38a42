#include "hgros/yaml/quoted.hpp"

#include <algorithm>
#include <cstddef>

namespace hgros::yaml {
namespace {

// A byte of a UTF-8 character other than its first.
bool InsideCharacter(char c) { return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U; }

}  // namespace

std::string Quoted(std::string_view text) {
  constexpr std::size_t kLongest = 60;
  std::string out = "\"";
  std::size_t end = std::min(text.size(), kLongest);
  while (end < text.size() && end > 0 && InsideCharacter(text[end])) --end;
  for (const char c : text.substr(0, end)) {
    if (c == '\n') {
      out += "\\n";
    } else if (c == '\t') {
      out += "\\t";
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) {
      out += '?';
    } else {
      out += c;
    }
  }
  if (end < text.size()) out += "...";
  return out + "\"";
}

}  // namespace hgros::yaml
