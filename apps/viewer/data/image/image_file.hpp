#pragma once

#include <string>

#include "hgros/base/bytes.hpp"
#include "viewer/data/image/image_picture.hpp"

namespace hgros::viewer {

/// Reads a PNG or JPEG into size and pixels of `picture`. A PNG with 16-bit gray holds measurements, which get the
/// colors of `colors`. At most 64 million pixels. Returns what is wrong with the file, as a sentence, or nothing. A
/// JPEG that can be read in part has ImagePicture::damage.
[[nodiscard]] std::string ReadImageFile(Bytes file, const DepthColors& colors, ImagePicture& picture);

}  // namespace hgros::viewer
