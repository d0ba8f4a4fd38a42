#include "viewer/data/image/image_value.hpp"

#include <cmath>
#include <cstdio>

namespace hgros::viewer {

std::string ValueAt(const ImagePicture& picture, std::size_t x, std::size_t y) {
  const std::size_t at = y * picture.width + x;
  char text[64];
  if (at < picture.values.size()) {
    const float value = picture.values[at];
    if (!std::isfinite(value) || value == 0) return "nothing measured";
    std::snprintf(text, sizeof text, "%.6g", static_cast<double>(value));
    return text;
  }
  if (4 * at + 3 >= picture.rgba.size()) return {};
  const std::uint8_t* const pixel = picture.rgba.data() + 4 * at;
  if (pixel[0] == pixel[1] && pixel[1] == pixel[2]) return std::to_string(pixel[0]);
  std::snprintf(text, sizeof text, "red %d, green %d, blue %d", pixel[0], pixel[1], pixel[2]);
  return text;
}

}  // namespace hgros::viewer
