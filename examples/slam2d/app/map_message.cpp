#include "map_message.hpp"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "frames.hpp"
#include "pose_message.hpp"

namespace slam2d {
namespace {

// -1: unknown. Otherwise the probability that the cell is occupied, in percent.
char Percent(std::int8_t value, const MapOptions& options) {
  if (value == 0) return -1;
  return static_cast<char>(100 * (value - options.min_value) / (options.max_value - options.min_value));
}

}  // namespace

std::unique_ptr<foxglove::Grid> GridMessage(const OccupancyMap& map, double stamp_seconds) {
  int min_x = std::numeric_limits<int>::max();
  int min_y = min_x;
  int max_x = std::numeric_limits<int>::min();
  int max_y = max_x;
  for (const auto& [index, tile] : map.tiles()) {
    min_x = std::min(min_x, index.x);
    min_y = std::min(min_y, index.y);
    max_x = std::max(max_x, index.x);
    max_y = std::max(max_y, index.y);
  }
  const auto columns = static_cast<std::size_t>(max_x - min_x + 1) * kTileEdgeCells;
  const auto rows = static_cast<std::size_t>(max_y - min_y + 1) * kTileEdgeCells;
  std::string cells(columns * rows, -1);
  for (const auto& [index, tile] : map.tiles()) {
    const auto left = static_cast<std::size_t>(index.x - min_x) * kTileEdgeCells;
    const auto bottom = static_cast<std::size_t>(index.y - min_y) * kTileEdgeCells;
    for (std::size_t cell = 0; cell < tile.size(); ++cell) {
      cells[(bottom + cell / kTileEdgeCells) * columns + left + cell % kTileEdgeCells] =
          Percent(tile[cell], map.options());
    }
  }

  const double cell_size = map.options().cell_size_m;
  auto grid = std::make_unique<foxglove::Grid>();
  const auto corner = PoseMessage({min_x * kTileEdgeCells * cell_size, min_y * kTileEdgeCells * cell_size, 0.0},
                                  stamp_seconds, kMapFrame);
  *grid->mutable_timestamp() = corner->timestamp();
  grid->set_frame_id(corner->frame_id());
  *grid->mutable_pose() = corner->pose();
  grid->set_column_count(static_cast<std::uint32_t>(columns));
  grid->mutable_cell_size()->set_x(cell_size);
  grid->mutable_cell_size()->set_y(cell_size);
  grid->set_row_stride(static_cast<std::uint32_t>(columns));
  grid->set_cell_stride(1);
  foxglove::PackedElementField& field = *grid->add_fields();
  field.set_name("occupancy");
  field.set_type(foxglove::PackedElementField::INT8);
  grid->set_data(std::move(cells));
  return grid;
}

}  // namespace slam2d
