#pragma once

#include <array>
#include <cstdint>

#include "viewer/data/color_map.hpp"

namespace hgros::viewer {

enum class ColorBy : std::uint8_t { kFlat, kAxis, kScalar, kRgb };

/// The appearance of points. Only the shader uses it, so a change does not upload points again.
struct PointStyle {
  ColorBy color_by = ColorBy::kAxis;
  std::array<float, 3> flat = {0.92F, 0.92F, 0.92F};
  int axis = 2;
  ColorMap map = ColorMap::kRainbow;
  double lo = 0;  ///< Range of the color map, in values or meters.
  double hi = 1;
  float size = 2;
  bool size_in_meters = false;  ///< Otherwise pixels.
};

}  // namespace hgros::viewer
