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
  std::vector<std::uint8_t> rgba;  ///< Rows from the top, 4 bytes per pixel.
  std::string encoding;            ///< Its name in the message.
  /// For images of measurements (16UC1, 32FC1): the values of the lowest and the highest color.
  std::optional<double> least, greatest;
  std::vector<float> values;  ///< The measurements, one per pixel.
};

/// How the values of depth images become colors.
struct DepthColors {
  ColorMap map = ColorMap::kRainbow;
  /// In the image's unit. None: the image's own range, without 0 and values that are not numbers.
  std::optional<double> least, greatest;
};

}  // namespace hgros::viewer
