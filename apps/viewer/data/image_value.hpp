#pragma once

#include <cstddef>
#include <string>

#include "viewer/data/image_picture.hpp"

namespace hgros::viewer {

/// What an image says at a pixel inside it: the measured value, or the colour as numbers.
[[nodiscard]] std::string ValueAt(const ImagePicture& picture, std::size_t x, std::size_t y);

}  // namespace hgros::viewer
