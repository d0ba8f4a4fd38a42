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

/// How scans enter the map. tunables.hpp tells what each number is, and its bounds.
struct MapOptions {
  double cell_size_m = 0.05;
  double max_hit_range_m = 30.0;
  double min_hit_range_m = 0.1;
  double max_bridge_m = 1.5;
  double bridge_tolerance_m = 0.05;  ///< By the two returns on either side of it.
  double min_bridge_offset_m = 0.6;  ///< Nearer, it is a veil of returns along an edge, not a wall.
  int hit_gain = 18;
  int miss_loss = 5;
  int max_value = 60;   ///< Small enough that moved furniture is forgotten.
  int min_value = -60;  ///< Free cells soon stop changing, which keeps deltas small.
  double min_translation_m = 0.15;
  double min_rotation_rad = 0.06;
};

inline constexpr int kTileEdgeCells = 64;

/// Position of a tile of kTileEdgeCells x kTileEdgeCells cells; tile (0, 0) begins at the map frame's origin.
struct TileIndex {
  std::int32_t x = 0;
  std::int32_t y = 0;

  friend auto operator<=>(const TileIndex&, const TileIndex&) = default;
};

/// New values of some cells: what turns one version of a map into the next, wherever a copy of it is held.
///
/// Flat arrays only, so that it goes through any codec as it is. The changes of tile i are the entries
/// [first_i, first_i + count_i) of `cells` and `values`; tiles and the cells in a tile ascend.
struct MapDelta {
  struct TileChanges {
    TileIndex tile;
    std::uint32_t first = 0;
    std::uint32_t count = 0;

    friend bool operator==(const TileChanges&, const TileChanges&) = default;
  };

  std::uint64_t version = 0;  ///< Sequence of the scan after which the map is as this delta makes it.
  std::vector<TileChanges> tiles;
  std::vector<std::uint16_t> cells;  ///< y * kTileEdgeCells + x in the tile.
  std::vector<std::int8_t> values;   ///< The new values.

  friend bool operator==(const MapDelta&, const MapDelta&) = default;
};

/// Growable 2-D occupancy grid of integers: above 0 occupied, below 0 free, 0 unknown (or undecided).
///
/// Values are log odds in units of MapOptions' gains, clamped. A scan changes a cell once, and a cell in which one of
/// its beams ends counts as hit even when others cross it. Where a wall is seen at a flat angle its returns lie far
/// apart; if four in a row are collinear, the cells between the middle two count as hit too, unless known to be free: a
/// row of lone cells would hold the next scans to exactly the same place along the wall. All integer, hence equal on
/// every machine that draws the same end points; a replica given every delta in order is equal bit for bit.
///
/// Threading: one thread at a time; const functions may run together.
class OccupancyMap {
 public:
  using Tile = std::array<std::int8_t, static_cast<std::size_t>(kTileEdgeCells) * kTileEdgeCells>;

  explicit OccupancyMap(const MapOptions& options = {});

  /// Scans are drawn with `options` from now on. The size and the range of cells stay as they are.
  void SetOptions(const MapOptions& options);

  /// Draws `scan`, taken at `T_map_laser`, into the map and returns what changed. The version becomes scan.sequence.
  MapDelta Integrate(const LaserScan2& scan, const Pose2& T_map_laser);

  /// The empty delta of a scan that was left out; the version becomes `sequence`.
  MapDelta Skip(std::uint64_t sequence);

  /// Makes this map what the map was that returned `delta`, provided all deltas before it were applied.
  ///
  /// Errors: throws std::invalid_argument, with the map unchanged, if the delta's indices or lengths contradict
  ///         themselves (it may come from another process).
  void Apply(const MapDelta& delta);

  /// Sequence of the scan that was integrated or skipped last; 0 before.
  [[nodiscard]] std::uint64_t version() const { return version_; }
  [[nodiscard]] const MapOptions& options() const { return options_; }

  /// In ascending order of their indices.
  [[nodiscard]] const std::map<TileIndex, Tile>& tiles() const { return tiles_; }

  /// Value of the cell with these cell coordinates; 0 outside of all tiles.
  [[nodiscard]] int At(int cell_x, int cell_y) const;

 private:
  MapOptions options_;
  std::uint64_t version_ = 0;
  std::map<TileIndex, Tile> tiles_;
};

}  // namespace slam2d
