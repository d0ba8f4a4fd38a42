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
  // Rows from the top, without padding. One of the two is empty.
  std::vector<std::uint8_t> rgba;  ///< 4 bytes per pixel.
  std::vector<std::uint8_t> gray;  ///< 1 byte per pixel.
  std::string encoding;            ///< Its name in the message.
  /// One sentence about a damaged file of which only a part is shown. Empty: the file is undamaged.
  std::string damage;
  /// For images of measurements (16UC1, 32FC1) and mono16: the values of the lowest and the highest color.
  std::optional<double> least, greatest;
  /// The measurements of a file, one per pixel. Those of a RawImage are read from the message (MeasurementAt).
  std::vector<float> values;
};

/// How the values of depth images become colors.
struct DepthColors {
  ColorMap map = ColorMap::kRainbow;
  /// In the image's unit. None: the image's own range, without 0 and values that are not numbers.
  std::optional<double> least, greatest;
};

}  // namespace hgros::viewer
