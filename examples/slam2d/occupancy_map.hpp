#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "laser_scan.hpp"
#include "pose2.hpp"

namespace slam2d {

/// How scans enter the map. tunables.hpp documents each number and its bounds.
struct MapOptions {
  double cell_size_m = 0.05;
  double max_hit_range_m = 30.0;
  double min_hit_range_m = 0.1;
  double max_bridge_m = 1.5;
  double bridge_tolerance_m = 0.05;  ///< Deviation of the two outer returns from its line.
  double min_bridge_offset_m = 0.6;  ///< Nearer lines are stray returns along an edge, not walls.
  int hit_gain = 18;
  int miss_loss = 5;
  int max_value = 60;   ///< Small enough that moved furniture is forgotten.
  int min_value = -60;  ///< Free cells soon stop changing, which keeps deltas small.
  double min_translation_m = 0.15;
  double min_rotation_rad = 0.06;
};

inline constexpr int kTileEdgeCells = 64;

/// Position of a tile of kTileEdgeCells x kTileEdgeCells cells. Tile (0, 0) begins at the map frame's origin.
struct TileIndex {
  std::int32_t x = 0;
  std::int32_t y = 0;

  friend auto operator<=>(const TileIndex&, const TileIndex&) = default;
};

/// New values of some cells. They turn one version of a map, or a copy of it, into the next.
///
/// Flat arrays only, so that any codec can carry it. The changes of tile i are the entries
/// [first_i, first_i + count_i) of `cells` and `values`. Tiles and the cells in a tile are in ascending order.
struct MapDelta {
  struct TileChanges {
    TileIndex tile;
    std::uint32_t first = 0;
    std::uint32_t count = 0;

    friend bool operator==(const TileChanges&, const TileChanges&) = default;
  };

  std::uint64_t version = 0;  ///< Sequence of the last scan in the map that this delta makes.
  std::vector<TileChanges> tiles;
  std::vector<std::uint16_t> cells;  ///< y * kTileEdgeCells + x in the tile.
  std::vector<std::int8_t> values;   ///< The new values.

  friend bool operator==(const MapDelta&, const MapDelta&) = default;
};

/// Growable 2-D occupancy grid of integers: above 0 occupied, below 0 free, 0 unknown (or undecided).
///
/// Values are log odds in units of MapOptions' gains, clamped. A scan changes a cell at most once. A cell in which one
/// of its beams ends counts as hit even if other beams cross it. Where a wall is seen at a flat angle its returns are
/// far apart. If four in a row are collinear, the cells between the middle two also count as hit, unless they are known
/// to be free. Otherwise a row of separate cells would hold the next scans at exactly the same place along the wall.
/// All arithmetic is in integers, so the map is equal on every machine that draws the same end points. A replica that
/// applies every delta in order is equal bit for bit.
///
/// Threading: one thread at a time; const functions may run concurrently.
class OccupancyMap {
 public:
  using Tile = std::array<std::int8_t, static_cast<std::size_t>(kTileEdgeCells) * kTileEdgeCells>;

  explicit OccupancyMap(const MapOptions& options = {});

  /// Draws scans with `options` from now on. The size of cells and the range of their values stay unchanged.
  void SetOptions(const MapOptions& options);

  /// Draws `scan`, taken at `T_map_laser`, into the map and returns the change. The version becomes scan.sequence.
  MapDelta Integrate(const LaserScan2& scan, const Pose2& T_map_laser);

  /// Returns the empty delta of a skipped scan. The version becomes `sequence`.
  MapDelta Skip(std::uint64_t sequence);

  /// Brings this map to the state of the map that returned `delta`. All earlier deltas must have been applied.
  ///
  /// Errors: throws std::invalid_argument, with the map unchanged, if the delta's indices or lengths are inconsistent.
  ///         The delta may come from another process.
  void Apply(const MapDelta& delta);

  /// Sequence of the scan that was integrated or skipped last; 0 before the first.
  [[nodiscard]] std::uint64_t version() const { return version_; }
  [[nodiscard]] const MapOptions& options() const { return options_; }

  /// In ascending order of their indices.
  [[nodiscard]] const std::map<TileIndex, Tile>& tiles() const { return tiles_; }

  /// Value of the cell with these cell coordinates; 0 outside all tiles.
  [[nodiscard]] int At(int cell_x, int cell_y) const;

 private:
  MapOptions options_;
  std::uint64_t version_ = 0;
  std::map<TileIndex, Tile> tiles_;
};

/// The delta that gives a replica of `before` the cells and the version of `after`, as Integrate() would return it.
[[nodiscard]] MapDelta Difference(const OccupancyMap& before, const OccupancyMap& after);

}  // namespace slam2d
