#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "viewer/data/number_series.hpp"

namespace hgros::viewer {

/// One line of a plot, cut into the canvas' columns.
struct PlotLine {
  std::string name;
  std::uint32_t color = 0;  ///< As ImGui has it.
  std::vector<NumberSeries::Column> columns;
};

/// So many columns are drawn in the room that is left in the current window.
[[nodiscard]] std::size_t PlotColumns();

/// Draws lines over the last `seconds` into the room that is left, with axes, and the values under the pointer.
/// `unit` is that of the values; empty: they have none, or not the same.
void DrawPlot(const std::vector<PlotLine>& lines, double seconds, const std::string& unit);

}  // namespace hgros::viewer
