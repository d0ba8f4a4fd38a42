#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "viewer/data/channels/hypergraph.hpp"

namespace hgros::viewer {

/// A hypergraph in three columns: publishers, channels, subscribers. A process that does both appears twice. Each
/// column is vertically centered and ordered so that few lines cross.
struct HypergraphLayout {
  enum class Column : std::uint8_t { kPublishers, kChannels, kSubscribers };
  struct Box {
    Column column = Column::kChannels;
    std::size_t index = 0;  ///< Index of the process or channel in the graph.
    float row = 0;          ///< From the top, in heights of a box.
  };
  struct Link {
    std::size_t from = 0;  ///< Indices into boxes: publisher and channel, or channel and subscriber.
    std::size_t to = 0;
    std::size_t line = 0;  ///< Index into the graph's lines.
  };
  std::vector<Box> boxes;
  std::vector<Link> links;
  std::size_t rows = 0;  ///< Boxes in the longest column.
};

[[nodiscard]] HypergraphLayout LayOut(const Hypergraph& graph);

}  // namespace hgros::viewer
