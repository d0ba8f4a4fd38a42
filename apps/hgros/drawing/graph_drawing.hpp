#pragma once

#include <string>

#include "robot/hypergraph.hpp"
#include "terminal/console.hpp"

namespace hgros::cli {

/// The graph for a terminal: hosts, in them processes from sources to sinks, and below each process what it publishes
/// and who hears it.
[[nodiscard]] std::string DrawText(const Hypergraph& graph, const Console& console, const OutputStyle& style);

/// For Graphviz.
[[nodiscard]] std::string DrawDot(const Hypergraph& graph, const OutputStyle& style);

/// A picture for browsers and documents. Processes are rows, time flows from left to right.
[[nodiscard]] std::string DrawSvg(const Hypergraph& graph, const OutputStyle& style);

}  // namespace hgros::cli
