#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "viewer/data/shapes/scene_shapes.hpp"

namespace hgros::viewer {

/// How the values of a grid become colors.
enum class GridPalette : std::uint8_t {
  kMap,      ///< Occupancy: 0 free (white) to 100 occupied (black); all other values unknown (gray green).
  kCostmap,  ///< Costs: 0 transparent, 1 to 98 from blue to red, 99 inscribed (cyan), 100 lethal (magenta); all others
             ///< unknown.
  kRaw,      ///< From black at the lowest value to white at the highest.
};
inline constexpr std::array<std::string_view, 3> kGridPaletteNames = {"map", "costmap", "raw"};

/// The color of a value with kMap or kCostmap. An unsigned byte above 127 means the negative signed byte.
[[nodiscard]] Rgba ColorOfCell(GridPalette palette, double value);
/// The color of a value with kRaw: black at `least`, white at `greatest`, transparent if it is not a number.
[[nodiscard]] Rgba GrayOfCell(double value, double least, double greatest);

}  // namespace hgros::viewer
