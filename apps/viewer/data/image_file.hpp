#pragma once

#include <string>

#include "hgros/base/bytes.hpp"
#include "viewer/data/image_picture.hpp"

namespace hgros::viewer {

/// Reads a png or jpeg into size and pixels of `picture`. Returns what is wrong with the file, in a sentence, or
/// nothing. A png of 16-bit grey is taken for measurements, coloured as `colors` say. At most 64 million pixels.
[[nodiscard]] std::string ReadImageFile(Bytes file, const DepthColors& colors, ImagePicture& picture);

}  // namespace hgros::viewer
