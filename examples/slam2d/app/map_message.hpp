#pragma once

#include <memory>

#include <foxglove/Grid.pb.h>

#include "../occupancy_map.hpp"

namespace slam2d {

/// The map for viewers: one signed byte for each cell, its probability in percent, or -1 if it is unknown. The map must
/// have at least one tile.
[[nodiscard]] std::unique_ptr<foxglove::Grid> GridMessage(const OccupancyMap& map, double stamp_seconds);

}  // namespace slam2d
