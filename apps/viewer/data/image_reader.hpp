#pragma once

#include <string>

#include "foxglove/CompressedImage.pb.h"
#include "foxglove/RawImage.pb.h"
#include "hgros/codec/bulk.hpp"
#include "viewer/data/image_picture.hpp"

namespace hgros::viewer {

/// Reads an image of any encoding that ImageView knows; 16UC1 and 32FC1 are measurements and are coloured. Returns what
/// is wrong, in a sentence, or nothing; then `picture` is what it was before.
[[nodiscard]] std::string ReadImage(const Bulk<foxglove::RawImage>& image, const DepthColors& colors,
                                    ImagePicture& picture);
/// Likewise a png or jpeg; the file itself says which. A png of 16-bit grey is taken for measurements.
[[nodiscard]] std::string ReadImage(const Bulk<foxglove::CompressedImage>& image, const DepthColors& colors,
                                    ImagePicture& picture);

}  // namespace hgros::viewer
