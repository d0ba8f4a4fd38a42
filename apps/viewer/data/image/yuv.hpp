#pragma once

#include <cstdint>
#include <vector>

#include "hgros/codec/image_view.hpp"

namespace hgros::viewer {

/// The order of the four bytes that two pixels share.
enum class YuvOrder : std::uint8_t { kYuyv, kUyvy };

/// Colors of a 4:2:2 image by ITU-R BT.601, limited range; `rgba` has its size. The last pixel of an odd row has only
/// half of its color and becomes gray.
void PaintYuv422(const ImageView& view, YuvOrder order, std::vector<std::uint8_t>& rgba);
/// The same for nv12, where four pixels share their color.
void PaintNv12(const ImageView& view, std::vector<std::uint8_t>& rgba);

}  // namespace hgros::viewer
