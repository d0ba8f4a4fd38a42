#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "foxglove/RawImage.pb.h"
#include "hgros/codec/bulk.hpp"

namespace hgros::viewer {

/// A measurement as text.
[[nodiscard]] std::string MeasurementText(float value);
/// A pixel's color as text: red, green and blue, or the brightness of a gray one.
[[nodiscard]] std::string ColorText(const std::array<std::uint8_t, 4>& rgba);
/// The value at a pixel of a 16UC1, 32FC1 or mono16 image as text. Empty if the image has colors or no such pixel.
[[nodiscard]] std::string MeasurementAt(const Bulk<foxglove::RawImage>& image, std::size_t x, std::size_t y);

}  // namespace hgros::viewer
