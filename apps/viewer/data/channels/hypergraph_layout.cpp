#include "viewer/data/channels/hypergraph_layout.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace hgros::viewer {
namespace {

using Column = HypergraphLayout::Column;
constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
constexpr int kSweeps = 6;

/// The boxes of each column, from top to bottom.
using Columns = std::array<std::vector<std::size_t>, 3>;

/// Orders a column by the mean place of each box's neighbors. Boxes without neighbors come last.
void OrderByNeighbors(std::vector<std::size_t>& column, const std::vector<std::vector<std::size_t>>& neighbors,
                      const std::vector<float>& rows) {
  std::vector<float> middle(rows.size(), std::numeric_limits<float>::max());
  for (const std::size_t box : column) {
    if (neighbors[box].empty()) continue;
    float sum = 0;
    for (const std::size_t other : neighbors[box]) sum += rows[other];
    middle[box] = sum / static_cast<float>(neighbors[box].size());
  }
  std::ranges::stable_sort(column, {}, [&](std::size_t box) { return middle[box]; });
}

void SetRows(const std::vector<std::size_t>& column, std::size_t most, std::vector<float>& rows) {
  const float above = 0.5F * static_cast<float>(most - column.size());
  for (std::size_t i = 0; i < column.size(); ++i) rows[column[i]] = above + static_cast<float>(i);
}

}  // namespace

HypergraphLayout LayOut(const Hypergraph& graph) {
  HypergraphLayout layout;
  Columns columns;
  const auto add = [&](Column column, std::size_t index) {
    columns[static_cast<std::size_t>(column)].push_back(layout.boxes.size());
    layout.boxes.push_back({column, index, 0});
    return layout.boxes.size() - 1;
  };
  std::array<std::vector<std::size_t>, 2> sides;
  for (auto& side : sides) side.assign(graph.processes.size(), kNone);
  std::vector<std::size_t> channels(graph.channels.size(), kNone);
  for (std::size_t i = 0; i < graph.channels.size(); ++i) channels[i] = add(Column::kChannels, i);
  for (std::size_t i = 0; i < graph.lines.size(); ++i) {
    const Hypergraph::Line& line = graph.lines[i];
    std::size_t& box = sides[line.publishes ? 0 : 1][line.process];
    if (box == kNone) box = add(line.publishes ? Column::kPublishers : Column::kSubscribers, line.process);
    const std::size_t channel = channels[line.channel];
    layout.links.push_back(line.publishes ? HypergraphLayout::Link{box, channel, i}
                                          : HypergraphLayout::Link{channel, box, i});
  }

  std::vector<std::vector<std::size_t>> neighbors(layout.boxes.size());
  for (const HypergraphLayout::Link& link : layout.links) {
    neighbors[link.from].push_back(link.to);
    neighbors[link.to].push_back(link.from);
  }
  for (const auto& column : columns) layout.rows = std::max(layout.rows, column.size());
  std::vector<float> rows(layout.boxes.size(), 0);
  for (const auto& column : columns) SetRows(column, layout.rows, rows);
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (const std::size_t at : {std::size_t{0}, std::size_t{2}, std::size_t{1}}) {
      OrderByNeighbors(columns[at], neighbors, rows);
      SetRows(columns[at], layout.rows, rows);
    }
  }
  for (std::size_t i = 0; i < rows.size(); ++i) layout.boxes[i].row = rows[i];
  return layout;
}

}  // namespace hgros::viewer
