#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "hgros/codec/image_view.hpp"

namespace hgros::viewer {

/// Which part (0 red, 1 green, 2 blue) each pixel of a square of two by two has: row by row from the top left.
using BayerPattern = std::array<std::uint8_t, 4>;

/// Of "bayer_rggb8" and its like.
[[nodiscard]] std::optional<BayerPattern> BayerPatternOf(std::string_view encoding);

/// Colours by averaging what the nearest pixels have (bilinear); `rgba` has the image's size.
void PaintBayer(const ImageView& view, const BayerPattern& pattern, std::vector<std::uint8_t>& rgba);

}  // namespace hgros::viewer
