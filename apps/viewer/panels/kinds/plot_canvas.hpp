#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "viewer/data/messages/number_series.hpp"

namespace hgros::viewer {

/// One line of a plot, as columns of the canvas.
struct PlotLine {
  std::string name;
  std::uint32_t color = 0;  ///< In ImGui's format.
  std::vector<NumberSeries::Column> columns;
};

/// Number of columns that fit into the rest of the current window.
[[nodiscard]] std::size_t PlotColumns();

/// Draws lines over the last `seconds` into the rest of the window, with axes and the values under the pointer. `unit`
/// is the unit of all values; empty if they have none or different ones.
void DrawPlot(const std::vector<PlotLine>& lines, double seconds, const std::string& unit);

}  // namespace hgros::viewer
