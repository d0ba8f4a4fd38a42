#include "likelihood_field.hpp"

#include <algorithm>
#include <cmath>

namespace slam2d {
namespace {

// The extent of the map's tiles, enlarged to whole groups of tiles so that it rarely grows, plus one group on each
// side, so that the search windows of points near the border are still inside.
constexpr int kGroupCells = 4 * kTileEdgeCells;

int FloorToGroup(int cell) {
  return static_cast<int>(std::floor(cell / static_cast<double>(kGroupCells))) * kGroupCells;
}

// `level` with a new extent; new cells are 0.
void Resize(int origin_x, int origin_y, int width, int height, LikelihoodField::Level& level) {
  LikelihoodField::Level grown{origin_x, origin_y, width, height, {}};
  grown.values.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int y = level.origin_y; y < level.origin_y + level.height; ++y) {
    const auto from = level.values.begin() + static_cast<std::ptrdiff_t>(level.Index(level.origin_x, y));
    std::copy(from, from + level.width,
              grown.values.begin() + static_cast<std::ptrdiff_t>(grown.Index(level.origin_x, y)));
  }
  level = std::move(grown);
}

}  // namespace

LikelihoodField::LikelihoodField(double cell_size_m, double sigma_m)
    : cell_size_m_(cell_size_m), radius_cells_(static_cast<int>(std::ceil(3.0 * sigma_m / cell_size_m))) {
  for (int y = -radius_cells_; y <= radius_cells_; ++y) {
    for (int x = -radius_cells_; x <= radius_cells_; ++x) {
      const double d_sigmas = std::hypot(x, y) * cell_size_m / sigma_m;
      kernel_.push_back(static_cast<std::uint8_t>(std::lround(255.0 * std::exp(-0.5 * d_sigmas * d_sigmas))));
    }
  }
}

void LikelihoodField::Apply(const MapDelta& delta) {
  for (const MapDelta::TileChanges& change : delta.tiles) {
    GrowTo(change.tile);
    for (std::size_t i = change.first; i < std::size_t{change.first} + change.count; ++i) {
      const int x = change.tile.x * kTileEdgeCells + delta.cells[i] % kTileEdgeCells;
      const int y = change.tile.y * kTileEdgeCells + delta.cells[i] / kTileEdgeCells;
      const bool occupied = delta.values[i] > 0;
      if (occupied != (occupied_[levels_[0].Index(x, y)] != 0)) SetOccupied(x, y, occupied);
    }
  }
  RefreshCoarseLevels();
}

void LikelihoodField::GrowTo(TileIndex tile) {
  const Level& fine = levels_[0];
  int min_x = FloorToGroup(tile.x * kTileEdgeCells) - kGroupCells;
  int min_y = FloorToGroup(tile.y * kTileEdgeCells) - kGroupCells;
  int max_x = min_x + 3 * kGroupCells;
  int max_y = min_y + 3 * kGroupCells;
  if (fine.width > 0) {
    min_x = std::min(min_x, fine.origin_x);
    min_y = std::min(min_y, fine.origin_y);
    max_x = std::max(max_x, fine.origin_x + fine.width);
    max_y = std::max(max_y, fine.origin_y + fine.height);
    if (max_x - min_x == fine.width && max_y - min_y == fine.height) return;
  }
  Level occupied = fine;
  occupied.values = std::move(occupied_);
  Resize(min_x, min_y, max_x - min_x, max_y - min_y, occupied);
  occupied_ = std::move(occupied.values);
  Level dirty = levels_[1];
  dirty.values = std::move(dirty_);
  for (std::size_t l = 0; l < kLevels; ++l) {
    const int s = kStride[l];
    Resize(min_x / s, min_y / s, (max_x - min_x) / s, (max_y - min_y) / s, levels_[l]);
    if (l == 1) Resize(min_x / s, min_y / s, (max_x - min_x) / s, (max_y - min_y) / s, dirty);
  }
  dirty_ = std::move(dirty.values);
}

void LikelihoodField::MarkDirty(int x, int y) {
  const TileIndex block{x >> 2, y >> 2};
  std::uint8_t& mark = dirty_[levels_[1].Index(block.x, block.y)];
  if (mark != 0) return;
  mark = 1;
  dirty_blocks_.push_back(block);
}

void LikelihoodField::SetOccupied(int x, int y, bool occupied) {
  Level& fine = levels_[0];
  const int r = radius_cells_;
  const int edge = 2 * r + 1;
  occupied_[fine.Index(x, y)] = occupied ? 1 : 0;
  occupied_cells_ += occupied ? 1U : static_cast<std::size_t>(-1);
  for (int dy = -r; dy <= r; ++dy) {
    for (int dx = -r; dx <= r; ++dx) {
      const std::uint8_t reached = kernel_[static_cast<std::size_t>((dy + r) * edge + dx + r)];
      std::uint8_t& value = fine.values[fine.Index(x + dx, y + dy)];
      if (occupied) {
        if (reached <= value) continue;
        value = reached;
      } else {
        // Only a cell that had its value from (x, y) can lose it. It takes the best of the others around it.
        if (reached < value || value == 0) continue;
        std::uint8_t best = 0;
        for (int ey = -r; ey <= r; ++ey) {
          const std::size_t row = fine.Index(x + dx - r, y + dy + ey);
          for (int ex = 0; ex < edge; ++ex) {
            if (occupied_[row + static_cast<std::size_t>(ex)] == 0) continue;
            best = std::max(best, kernel_[static_cast<std::size_t>((ey + r) * edge + ex)]);
          }
        }
        if (best == value) continue;
        value = best;
      }
      MarkDirty(x + dx, y + dy);
    }
  }
}

void LikelihoodField::RefreshCoarseLevels() {
  static_assert(kStride[1] == 4 && kStride[2] == 16);
  const Level& fine = levels_[0];
  std::vector<TileIndex> dirty_2;
  // Level 1 at (x, y) covers the blocks (x, y) .. (x + 1, y + 1).
  for (const TileIndex& block : dirty_blocks_) {
    dirty_[levels_[1].Index(block.x, block.y)] = 0;
    for (int y = block.y - 1; y <= block.y; ++y) {
      for (int x = block.x - 1; x <= block.x; ++x) {
        std::uint8_t best = 0;
        for (int row = 0; row < 8; ++row) {
          const auto* cells = &fine.values[fine.Index(4 * x, 4 * y + row)];
          best = std::max(best, *std::max_element(cells, cells + 8));
        }
        levels_[1].values[levels_[1].Index(x, y)] = best;
        dirty_2.push_back({x >> 2, y >> 2});
      }
    }
  }
  dirty_blocks_.clear();
  std::ranges::sort(dirty_2);
  dirty_2.erase(std::unique(dirty_2.begin(), dirty_2.end()), dirty_2.end());
  // Level 2 at (x, y) covers level 1 at 4 x .. 4 x + 6, whose last one ends 32 cells after the first begins.
  for (const TileIndex& block : dirty_2) {
    for (int y = block.y - 1; y <= block.y; ++y) {
      for (int x = block.x - 1; x <= block.x; ++x) {
        std::uint8_t best = 0;
        for (int row = 0; row < 7; ++row) {
          const auto* cells = &levels_[1].values[levels_[1].Index(4 * x, 4 * y + row)];
          best = std::max(best, *std::max_element(cells, cells + 7));
        }
        levels_[2].values[levels_[2].Index(x, y)] = best;
      }
    }
  }
}

LikelihoodField::Sample LikelihoodField::At(const Point2& p_cells) const {
  const Level& fine = levels_[0];
  const double x = p_cells.x - 0.5;  // Values are at cell centers.
  const double y = p_cells.y - 0.5;
  const double floor_x = std::floor(x);
  const double floor_y = std::floor(y);
  const int ix = static_cast<int>(floor_x);
  const int iy = static_cast<int>(floor_y);
  if (!fine.Holds(ix, iy) || !fine.Holds(ix + 1, iy + 1)) return {};
  const std::uint8_t* low = &fine.values[fine.Index(ix, iy)];
  const std::uint8_t* high = low + fine.width;
  const double u = x - floor_x;
  const double v = y - floor_y;
  constexpr double kUnit = 1.0 / 255.0;
  const double v00 = low[0] * kUnit;
  const double v10 = low[1] * kUnit;
  const double v01 = high[0] * kUnit;
  const double v11 = high[1] * kUnit;
  return {(1.0 - v) * ((1.0 - u) * v00 + u * v10) + v * ((1.0 - u) * v01 + u * v11),
          (1.0 - v) * (v10 - v00) + v * (v11 - v01), (1.0 - u) * (v01 - v00) + u * (v11 - v10)};
}

}  // namespace slam2d
