#pragma once

#include <cstdint>
#include <vector>

#include "hgros/codec/image_view.hpp"

namespace hgros::viewer {

/// How two pixels share four bytes.
enum class YuvOrder : std::uint8_t { kYuyv, kUyvy };

/// Colours of a 4:2:2 image by ITU-R BT.601, limited range; `rgba` has its size. The last pixel of an odd row has half
/// of its colour only: it is taken for grey.
void PaintYuv422(const ImageView& view, YuvOrder order, std::vector<std::uint8_t>& rgba);

}  // namespace hgros::viewer
