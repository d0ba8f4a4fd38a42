#pragma once

#include <optional>
#include <utility>

#include "laser_scan.hpp"
#include "occupancy_map.hpp"
#include "scan_matcher.hpp"

namespace slam2d {

/// Owns the map: takes every matched scan and draws those into it that show something new.
///
/// Threading: one thread at a time.
class Mapper {
 public:
  explicit Mapper(const MapOptions& options) : map_(options) {}
  /// Goes on where another one stopped, with its map() and its T_map_drawn().
  Mapper(OccupancyMap map, std::optional<Pose2> T_map_drawn) : map_(std::move(map)), T_map_drawn_(T_map_drawn) {}

  /// As OccupancyMap::SetOptions.
  void SetOptions(const MapOptions& options) { map_.SetOptions(options); }

  /// Draws `scan` at `match` into the map if the laser has moved or turned enough since the last scan drawn. The delta
  /// carries the scan's sequence as version either way.
  MapDelta Add(const LaserScan2& scan, const ScanMatch& match);

  [[nodiscard]] const OccupancyMap& map() const { return map_; }
  /// Where the laser was when the last scan was drawn; nothing before the first.
  [[nodiscard]] const std::optional<Pose2>& T_map_drawn() const { return T_map_drawn_; }

 private:
  OccupancyMap map_;
  std::optional<Pose2> T_map_drawn_;
};

}  // namespace slam2d
