#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "viewer/data/scene_shapes.hpp"

namespace hgros::viewer {

/// How the values of a grid become colours.
enum class GridPalette : std::uint8_t {
  kMap,  ///< Occupancy: 0 free (white) to 100 occupied (black); -1 (and what is no such value) unknown (grey green).
  kCostmap,  ///< Costs: 0 nothing, 1 to 98 from blue to red, 99 inscribed (cyan), 100 lethal (magenta); unknown as
             ///< above.
  kRaw,      ///< From black at the least value to white at the greatest.
};
inline constexpr std::array<std::string_view, 3> kGridPaletteNames = {"map", "costmap", "raw"};

/// Of kMap and kCostmap. `value` is what the cell says; an unsigned byte above 127 stands for the signed one.
[[nodiscard]] Rgba ColorOfCell(GridPalette palette, double value);
/// Of kRaw: between black at `least` and white at `greatest`; no colour for what is no number.
[[nodiscard]] Rgba GrayOfCell(double value, double least, double greatest);

}  // namespace hgros::viewer
