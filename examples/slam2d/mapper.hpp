#pragma once

#include <optional>
#include <utility>

#include "laser_scan.hpp"
#include "occupancy_map.hpp"
#include "scan_matcher.hpp"

namespace slam2d {

/// Owns the map. Takes every matched scan and draws those that show something new.
///
/// Threading: one thread at a time.
class Mapper {
 public:
  explicit Mapper(const MapOptions& options) : map_(options) {}
  /// Continues where another mapper stopped, with its map() and its T_map_drawn().
  Mapper(OccupancyMap map, std::optional<Pose2> T_map_drawn) : map_(std::move(map)), T_map_drawn_(T_map_drawn) {}

  /// See OccupancyMap::SetOptions.
  void SetOptions(const MapOptions& options) { map_.SetOptions(options); }

  /// Draws `scan` at `match` into the map if the laser has moved or turned enough since the last scan drawn. In both
  /// cases the delta has the scan's sequence as version.
  MapDelta Add(const LaserScan2& scan, const ScanMatch& match);

  [[nodiscard]] const OccupancyMap& map() const { return map_; }
  /// Pose of the laser when the last scan was drawn. Empty before the first.
  [[nodiscard]] const std::optional<Pose2>& T_map_drawn() const { return T_map_drawn_; }

 private:
  OccupancyMap map_;
  std::optional<Pose2> T_map_drawn_;
};

}  // namespace slam2d
