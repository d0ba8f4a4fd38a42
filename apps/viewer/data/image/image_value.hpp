#pragma once

#include <cstddef>
#include <string>

#include "viewer/data/image/image_picture.hpp"

namespace hgros::viewer {

/// The value of a pixel inside the image as text: the measurement, or the color as numbers.
[[nodiscard]] std::string ValueAt(const ImagePicture& picture, std::size_t x, std::size_t y);

}  // namespace hgros::viewer
