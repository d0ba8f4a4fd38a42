#pragma once

#include "viewer/data/image/image_picture.hpp"

namespace hgros::viewer {

/// Colors a picture by its values, row by row. 0 and values that are not finite mean "not measured" and are
/// transparent. Writes the range of the colors into `picture`.
void PaintDepth(const DepthColors& colors, ImagePicture& picture);

}  // namespace hgros::viewer
