#pragma once

#include <span>

#include "viewer/data/picture.hpp"

namespace hgros::viewer {

/// Colours measurements, row by row, into `picture`, whose size they have; 0 and what is no finite number means that
/// nothing was measured, and is transparent. Tells the range of the colours in `picture`.
void PaintDepth(std::span<const float> values, const DepthColors& colors, Picture& picture);

}  // namespace hgros::viewer
