#include "map_owner.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace slam2d {

MapDelta MapOwner::Add(const LaserScan2& scan, const ScanMatch& match) {
  next_scan_ = scan.sequence + 1;
  if (T_map_drawn_) {
    const Pose2 motion = Inverse(*T_map_drawn_) * match.T_map_laser;
    const bool still =
        Distance(motion) < map_.options().min_translation_m && std::abs(motion.theta) < map_.options().min_rotation_rad;
    if (still || !match.drawable) return map_.Skip(scan.sequence);
  }
  T_map_drawn_ = match.T_map_laser;
  return map_.Integrate(scan, match.T_map_laser);
}

void MapOwner::Save(msg::MapState& state) const {
  state.set_next_scan(next_scan_);
  MapDelta all;
  all.version = map_.version();
  for (const auto& [index, tile] : map_.tiles()) {
    const auto first = static_cast<std::uint32_t>(all.cells.size());
    for (std::size_t cell = 0; cell < tile.size(); ++cell) {
      if (tile[cell] == 0) continue;
      all.cells.push_back(static_cast<std::uint16_t>(cell));
      all.values.push_back(tile[cell]);
    }
    all.tiles.push_back({index, first, static_cast<std::uint32_t>(all.cells.size()) - first});
  }
  Write(all, *state.mutable_map());
  if (T_map_drawn_) Write(*T_map_drawn_, *state.mutable_drawn());
}

void MapOwner::Restore(const msg::MapState& state) {
  OccupancyMap map;
  map.Apply(Read(state.map()));
  map_ = std::move(map);
  T_map_drawn_.reset();
  if (state.has_drawn()) T_map_drawn_ = Read(state.drawn());
  next_scan_ = state.next_scan();
}

}  // namespace slam2d
