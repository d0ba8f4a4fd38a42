#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "hgros/codec/image_view.hpp"

namespace hgros::viewer {

/// The color channel (0 red, 1 green, 2 blue) of each pixel in a square of two by two, row by row from the top left.
using BayerPattern = std::array<std::uint8_t, 4>;

/// The pattern of an encoding such as "bayer_rggb8" or "bayer_rggb16".
[[nodiscard]] std::optional<BayerPattern> BayerPatternOf(std::string_view encoding);

/// Computes colors as the mean of the nearest pixels (bilinear). `rgba` has the image's size, which is above zero.
void PaintBayer(const ImageView& view, const BayerPattern& pattern, std::vector<std::uint8_t>& rgba);

}  // namespace hgros::viewer
