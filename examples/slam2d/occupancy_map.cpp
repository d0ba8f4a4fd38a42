#include "occupancy_map.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>
#include <utility>

namespace slam2d {
namespace {

constexpr int kTileShift = 6;
constexpr int kTileMask = kTileEdgeCells - 1;
static_assert(1 << kTileShift == kTileEdgeCells);

// The cells that one scan touches, one bit per cell: one 64-bit word is one row of a tile.
class ScanFootprint {
 public:
  struct Bits {
    std::array<std::uint64_t, kTileEdgeCells> hit{};
    std::array<std::uint64_t, kTileEdgeCells> bridged{};
    std::array<std::uint64_t, kTileEdgeCells> crossed{};
  };

  void MarkHit(int x, int y) { At(x, y).hit[Row(y)] |= Bit(x); }
  void MarkBridged(int x, int y) { At(x, y).bridged[Row(y)] |= Bit(x); }
  void MarkCrossed(int x, int y) { At(x, y).crossed[Row(y)] |= Bit(x); }
  [[nodiscard]] const std::map<TileIndex, Bits>& tiles() const { return tiles_; }

 private:
  static std::size_t Row(int y) { return static_cast<std::size_t>(y & kTileMask); }
  static std::uint64_t Bit(int x) { return std::uint64_t{1} << static_cast<unsigned>(x & kTileMask); }

  // Neighboring cells are mostly in the same tile, so the last tile found is kept.
  Bits& At(int x, int y) {
    const TileIndex tile{x >> kTileShift, y >> kTileShift};
    if (last_ == nullptr || tile != last_tile_) {
      last_ = &tiles_[tile];
      last_tile_ = tile;
    }
    return *last_;
  }

  std::map<TileIndex, Bits> tiles_;
  TileIndex last_tile_;
  Bits* last_ = nullptr;
};

int CellOf(double coordinate_cells) { return static_cast<int>(std::floor(coordinate_cells)); }

// Calls mark(x, y) for the cells from `from` up to the cell that contains `to`, excluding it. Coordinates in cells.
// Amanatides and Woo, A Fast Voxel Traversal Algorithm for Ray Tracing, 1987.
template <typename Mark>
void Traverse(const Point2& from, const Point2& to, Mark mark) {
  int x = CellOf(from.x);
  int y = CellOf(from.y);
  const int end_x = CellOf(to.x);
  const int end_y = CellOf(to.y);
  const double dx = to.x - from.x;
  const double dy = to.y - from.y;
  const int step_x = dx > 0.0 ? 1 : -1;
  const int step_y = dy > 0.0 ? 1 : -1;
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const double per_x = dx != 0.0 ? std::abs(1.0 / dx) : kNever;
  const double per_y = dy != 0.0 ? std::abs(1.0 / dy) : kNever;
  double next_x = dx != 0.0 ? ((dx > 0.0 ? x + 1.0 : x) - from.x) / dx : kNever;
  double next_y = dy != 0.0 ? ((dy > 0.0 ? y + 1.0 : y) - from.y) / dy : kNever;
  for (int left = std::abs(end_x - x) + std::abs(end_y - y); left > 0; --left) {
    mark(x, y);
    if (next_x < next_y) {
      x += step_x;
      next_x += per_x;
    } else {
      y += step_y;
      next_y += per_y;
    }
  }
}

// Distance of `p` from the line through `a` and `b`, two different points.
double OffLine(const Point2& p, const Point2& a, const Point2& b) {
  const double dx = b.x - a.x;
  const double dy = b.y - a.y;
  return std::abs(dx * (p.y - a.y) - dy * (p.x - a.x)) / std::sqrt(dx * dx + dy * dy);
}

// Whether the last four of `returns` (of neighboring beams of a laser at `origin`, in cells) show a straight wall
// between the middle two.
bool EndsInWall(const std::vector<Point2>& returns, const Point2& origin, const MapOptions& options) {
  const std::size_t n = returns.size();
  if (n < 4) return false;
  const Point2& b = returns[n - 3];
  const Point2& c = returns[n - 2];
  const double gap_m = std::sqrt((c.x - b.x) * (c.x - b.x) + (c.y - b.y) * (c.y - b.y)) * options.cell_size_m;
  if (gap_m < options.cell_size_m || gap_m > options.max_bridge_m) return false;
  const double tolerance = options.bridge_tolerance_m / options.cell_size_m;
  if (OffLine(origin, b, c) * options.cell_size_m < options.min_bridge_offset_m) return false;
  return OffLine(returns[n - 4], b, c) < tolerance && OffLine(returns[n - 1], b, c) < tolerance;
}

void CheckShape(const MapDelta& delta) {
  std::size_t next = 0;
  for (const MapDelta::TileChanges& change : delta.tiles) {
    if (change.first != next || change.count > delta.cells.size() - next) {
      throw std::invalid_argument("The tiles of a map delta do not match its cells.");
    }
    next += change.count;
  }
  if (next != delta.cells.size() || delta.cells.size() != delta.values.size()) {
    throw std::invalid_argument("A map delta does not have one value for each cell.");
  }
  constexpr auto kCells = std::tuple_size_v<OccupancyMap::Tile>;
  if (std::ranges::any_of(delta.cells, [](std::uint16_t cell) { return cell >= kCells; })) {
    throw std::invalid_argument("A map delta has a cell outside its tile.");
  }
}

}  // namespace

OccupancyMap::OccupancyMap(const MapOptions& options) : options_(options) {
  if (!(options.cell_size_m > 0.0) || options.max_value > 127 || options.min_value < -127) {
    throw std::invalid_argument("A map needs a positive cell size and values within -127..127.");
  }
}

void OccupancyMap::SetOptions(const MapOptions& options) {
  const MapOptions before = std::exchange(options_, options);
  options_.cell_size_m = before.cell_size_m;
  options_.max_value = before.max_value;
  options_.min_value = before.min_value;
}

MapDelta OccupancyMap::Integrate(const LaserScan2& scan, const Pose2& T_map_laser) {
  const double cells_per_m = 1.0 / options_.cell_size_m;
  const Point2 origin{T_map_laser.x * cells_per_m, T_map_laser.y * cells_per_m};
  ScanFootprint footprint;
  const auto mark_bridged = [&](int x, int y) { footprint.MarkBridged(x, y); };
  const auto mark_crossed = [&](int x, int y) { footprint.MarkCrossed(x, y); };
  std::vector<Point2> returns;  // The returns of neighboring beams, up to the current one.
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const double range = scan.ranges_m[i];
    if (range >= scan.max_range_m || range < options_.min_hit_range_m) {
      returns.clear();
      continue;
    }
    const double angle = T_map_laser.theta + scan.start_angle_rad + static_cast<double>(i) * scan.angle_step_rad;
    const double reach = std::min(range, options_.max_hit_range_m) * cells_per_m;
    const Point2 end{origin.x + reach * std::cos(angle), origin.y + reach * std::sin(angle)};
    Traverse(origin, end, mark_crossed);
    if (range > options_.max_hit_range_m) {
      returns.clear();
      continue;
    }
    footprint.MarkHit(CellOf(end.x), CellOf(end.y));
    returns.push_back(end);
    if (EndsInWall(returns, origin, options_)) {
      Traverse(returns[returns.size() - 3], returns[returns.size() - 2], mark_bridged);
    }
  }

  MapDelta delta;
  delta.version = version_ = scan.sequence;
  for (const auto& [index, bits] : footprint.tiles()) {
    const auto [place, is_new] = tiles_.try_emplace(index);
    Tile& tile = place->second;
    const auto first = static_cast<std::uint32_t>(delta.cells.size());
    for (std::size_t row = 0; row < bits.hit.size(); ++row) {
      for (std::uint64_t left = bits.hit[row] | bits.bridged[row] | bits.crossed[row]; left != 0; left &= left - 1) {
        const auto column = static_cast<unsigned>(std::countr_zero(left));
        const std::size_t cell = row * kTileEdgeCells + column;
        const bool crossed = ((bits.crossed[row] >> column) & 1U) != 0;
        const bool bridged = ((bits.bridged[row] >> column) & 1U) != 0 && tile[cell] >= 0;
        const bool hit = ((bits.hit[row] >> column) & 1U) != 0 || bridged;
        if (!hit && !crossed) continue;
        const int change = hit ? options_.hit_gain : -options_.miss_loss;
        const auto value =
            static_cast<std::int8_t>(std::clamp(tile[cell] + change, options_.min_value, options_.max_value));
        if (value == tile[cell]) continue;
        tile[cell] = value;
        delta.cells.push_back(static_cast<std::uint16_t>(cell));
        delta.values.push_back(value);
      }
    }
    const auto count = static_cast<std::uint32_t>(delta.cells.size()) - first;
    if (count > 0) {
      delta.tiles.push_back({index, first, count});
    } else if (is_new) {
      tiles_.erase(place);  // No delta creates it in a replica.
    }
  }
  return delta;
}

MapDelta OccupancyMap::Skip(std::uint64_t sequence) {
  MapDelta delta;
  delta.version = version_ = sequence;
  return delta;
}

void OccupancyMap::Apply(const MapDelta& delta) {
  CheckShape(delta);
  for (const MapDelta::TileChanges& change : delta.tiles) {
    Tile& tile = tiles_.try_emplace(change.tile).first->second;
    for (std::size_t i = change.first; i < std::size_t{change.first} + change.count; ++i) {
      tile[delta.cells[i]] = delta.values[i];
    }
  }
  version_ = delta.version;
}

MapDelta Difference(const OccupancyMap& before, const OccupancyMap& after) {
  static const OccupancyMap::Tile kUnknown{};
  const auto tile_of = [](const OccupancyMap& map, const TileIndex& index) -> const OccupancyMap::Tile& {
    const auto found = map.tiles().find(index);
    return found == map.tiles().end() ? kUnknown : found->second;
  };
  std::set<TileIndex> indices;
  for (const auto& [index, tile] : before.tiles()) indices.insert(index);
  for (const auto& [index, tile] : after.tiles()) indices.insert(index);
  MapDelta delta;
  delta.version = after.version();
  for (const TileIndex& index : indices) {
    const OccupancyMap::Tile& from = tile_of(before, index);
    const OccupancyMap::Tile& to = tile_of(after, index);
    const auto first = static_cast<std::uint32_t>(delta.cells.size());
    for (std::size_t cell = 0; cell < to.size(); ++cell) {
      if (from[cell] == to[cell]) continue;
      delta.cells.push_back(static_cast<std::uint16_t>(cell));
      delta.values.push_back(to[cell]);
    }
    const auto count = static_cast<std::uint32_t>(delta.cells.size()) - first;
    if (count > 0) delta.tiles.push_back({index, first, count});
  }
  return delta;
}

int OccupancyMap::At(int cell_x, int cell_y) const {
  const auto found = tiles_.find({cell_x >> kTileShift, cell_y >> kTileShift});
  if (found == tiles_.end()) return 0;
  const auto row = static_cast<std::size_t>(cell_y & kTileMask);
  return found->second[row * kTileEdgeCells + static_cast<std::size_t>(cell_x & kTileMask)];
}

}  // namespace slam2d
