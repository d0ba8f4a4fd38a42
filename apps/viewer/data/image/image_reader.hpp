#pragma once

#include <string>

#include "foxglove/CompressedImage.pb.h"
#include "foxglove/RawImage.pb.h"
#include "hgros/codec/bulk.hpp"
#include "viewer/data/image/image_picture.hpp"

namespace hgros::viewer {

/// Reads an image of any encoding that ImageView knows. 16UC1 and 32FC1 are measurements and get colors, mono16 gets
/// their range. Returns what is wrong, as a sentence, or nothing. After an error, `picture` is unchanged.
[[nodiscard]] std::string ReadImage(const Bulk<foxglove::RawImage>& image, const DepthColors& colors,
                                    ImagePicture& picture);
/// The same for a PNG or JPEG; the file itself says which. A PNG with 16-bit gray holds measurements.
[[nodiscard]] std::string ReadImage(const Bulk<foxglove::CompressedImage>& image, const DepthColors& colors,
                                    ImagePicture& picture);

}  // namespace hgros::viewer
