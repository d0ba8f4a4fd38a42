#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hgros/clock/time.hpp"
#include "viewer/data/color_map.hpp"

namespace hgros::viewer {

/// An image as it is shown.
struct ImagePicture {
  std::string frame;
  Time stamp;
  std::size_t width = 0, height = 0;
  std::vector<std::uint8_t> rgba;  ///< Rows from the top, 4 bytes a pixel.
  std::string encoding;            ///< As the message names it.
  /// Of images of measurements (16UC1, 32FC1): the values that the colours stand for.
  std::optional<double> least, greatest;
  std::vector<float> values;  ///< Those measurements, a pixel each.
};

/// How the values of depth images become colours.
struct DepthColors {
  ColorMap map = ColorMap::kRainbow;
  std::optional<double> least, greatest;  ///< In the image's unit; nothing: the image's own, 0 and no number left out.
};

}  // namespace hgros::viewer
