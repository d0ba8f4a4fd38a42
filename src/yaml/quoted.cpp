#include "hgros/yaml/quoted.hpp"

#include <algorithm>
#include <cstddef>

#include "hgros/base/readable_text.hpp"

namespace hgros::yaml {
namespace {

// A byte of a UTF-8 character other than its first.
bool InsideCharacter(char c) { return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U; }

}  // namespace

std::string Quoted(std::string_view text) {
  constexpr std::size_t kLongest = 60;
  std::size_t end = std::min(text.size(), kLongest);
  while (end < text.size() && end > 0 && InsideCharacter(text[end])) --end;
  return "\"" + Readable(text.substr(0, end)) + (end < text.size() ? "...\"" : "\"");
}

}  // namespace hgros::yaml
