#include "map_owner.hpp"

#include <optional>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace slam2d {

namespace {

// Compares the options that cannot change once a map is begun: those of this mapper and those of the received map.
void RequireSame(const MapOptions& ours, const MapOptions& theirs) {
  const auto require = [](const char* name, double our_value, double their_value) {
    if (our_value == their_value) return;
    std::ostringstream text;
    text << "the received map has slam.map." << name << " = " << their_value << ", but here it is " << our_value
         << ". Start both mappers with the same value.";
    throw std::invalid_argument(text.str());
  };
  require("cell_size_m", ours.cell_size_m, theirs.cell_size_m);
  require("min_value", ours.min_value, theirs.min_value);
  require("max_value", ours.max_value, theirs.max_value);
}

}  // namespace

MapDelta MapOwner::Add(const LaserScan2& scan, const ScanMatch& match) {
  next_scan_ = scan.sequence + 1;
  return mapper_.Add(scan, match);
}

void MapOwner::Save(msg::MapState& state) const {
  state.set_next_scan(next_scan_);
  MapDelta all;
  all.version = map().version();
  for (const auto& [index, tile] : map().tiles()) {
    const auto first = static_cast<std::uint32_t>(all.cells.size());
    for (std::size_t cell = 0; cell < tile.size(); ++cell) {
      if (tile[cell] == 0) continue;
      all.cells.push_back(static_cast<std::uint16_t>(cell));
      all.values.push_back(tile[cell]);
    }
    all.tiles.push_back({index, first, static_cast<std::uint32_t>(all.cells.size()) - first});
  }
  Write(all, *state.mutable_map());
  Write(map().options(), *state.mutable_map()->mutable_layout());
  if (mapper_.T_map_drawn()) Write(*mapper_.T_map_drawn(), *state.mutable_drawn());
}

void MapOwner::Restore(const msg::MapState& state) {
  OccupancyMap map(mapper_.map().options());
  RequireSame(map.options(), Read(state.map().layout()));
  map.Apply(Read(state.map()));
  std::optional<Pose2> drawn;
  if (state.has_drawn()) drawn = Read(state.drawn());
  mapper_ = Mapper(std::move(map), drawn);
  next_scan_ = state.next_scan();
}

}  // namespace slam2d
