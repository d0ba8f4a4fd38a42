#pragma once

#include "viewer/data/image_picture.hpp"

namespace hgros::viewer {

/// Colours a picture by its values, row by row; 0 and what is no finite number means that nothing was measured, and is
/// transparent. Tells the range of the colours in `picture`.
void PaintDepth(const DepthColors& colors, ImagePicture& picture);

}  // namespace hgros::viewer
