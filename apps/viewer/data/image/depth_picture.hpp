#pragma once

#include <cstddef>
#include <functional>
#include <span>

#include "viewer/data/image/image_picture.hpp"

namespace hgros::viewer {

/// Writes the measurements of row `y` into `row`, which is as long as the picture is wide.
using ReadDepthRow = std::function<void(std::size_t y, std::span<float> row)>;

/// Colors a picture by its measurements, which are read twice. 0 and values that are not finite mean "not measured" and
/// are transparent. Writes the range of the colors into `picture`, which has its size: at least one pixel.
void PaintDepth(const DepthColors& colors, const ReadDepthRow& read, ImagePicture& picture);

}  // namespace hgros::viewer
