#include "viewer/data/cut_text.hpp"

namespace hgros::viewer {

std::string_view CutText(std::string_view text, std::size_t most) noexcept {
  if (text.size() <= most) return text;
  std::size_t end = most;
  // Bytes that continue a character begin with the bits 10. There are at most three of them.
  for (int back = 0; back < 3 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U; ++back) --end;
  return text.substr(0, end);
}

}  // namespace hgros::viewer
