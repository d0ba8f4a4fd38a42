#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "occupancy_map.hpp"

namespace slam2d {

/// The likelihood that a beam ends at a place, 0..255, for every cell of a map: 255 * exp(-d^2 / (2 sigma^2)) with the
/// distance d to the nearest occupied cell (Thrun, Burgard, Fox, Probabilistic Robotics, sec. 6.4). Only the map's
/// deltas update it.
///
/// Two coarse levels serve branch and bound (Olson, Real-Time Correlative Scan Matching, ICRA 2009): the value at
/// (x, y) of level l with stride s = kStride[l] is the maximum over the cells [s x, s x + 2 s) x [s y, s y + 2 s), an
/// upper bound for a point of cell (c, d), floor(c / s) = x, floor(d / s) = y, moved by 0 .. s cells along each axis.
///
/// Invariant: the whole content, extent included, is a function of the map alone, not of its history.
/// Threading: one thread at a time; const functions may run concurrently.
class LikelihoodField {
 public:
  static constexpr std::size_t kLevels = 3;
  static constexpr std::array<int, kLevels> kStride{1, 4, 16};

  /// One level: `values[y * width + x]` is the value at level coordinates (x + origin_x, y + origin_y).
  struct Level {
    int origin_x = 0;
    int origin_y = 0;
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> values;

    [[nodiscard]] std::size_t Index(int x, int y) const {
      return static_cast<std::size_t>(y - origin_y) * static_cast<std::size_t>(width) +
             static_cast<std::size_t>(x - origin_x);
    }
    [[nodiscard]] bool Holds(int x, int y) const {
      return x >= origin_x && y >= origin_y && x < origin_x + width && y < origin_y + height;
    }
  };

  LikelihoodField(double cell_size_m, double sigma_m);

  /// Follows the map. `delta` is what OccupancyMap returned. Every delta must come in order, with its shape checked.
  void Apply(const MapDelta& delta);

  [[nodiscard]] const Level& level(std::size_t index) const { return levels_[index]; }
  [[nodiscard]] double cell_size_m() const { return cell_size_m_; }
  [[nodiscard]] bool empty() const { return occupied_cells_ == 0; }

  struct Sample {
    double value = 0.0;  ///< 0..1
    double dx = 0.0;     ///< Its derivative, 1/cell.
    double dy = 0.0;
  };

  /// Bilinear between cell centers, at `p_cells` in cells of the map frame. All 0 outside the field.
  [[nodiscard]] Sample At(const Point2& p_cells) const;

 private:
  void GrowTo(TileIndex tile);
  void SetOccupied(int x, int y, bool occupied);
  void MarkDirty(int x, int y);
  void RefreshCoarseLevels();

  double cell_size_m_;
  int radius_cells_;
  std::vector<std::uint8_t> kernel_;  // Square of edge 2 * radius_cells_ + 1.
  std::array<Level, kLevels> levels_;
  std::vector<std::uint8_t> occupied_;  // Same layout as levels_[0].
  std::vector<std::uint8_t> dirty_;  // Same layout as levels_[1]: a fine cell in its stride x stride block has changed.
  std::vector<TileIndex> dirty_blocks_;  // In level 1 coordinates.
  std::size_t occupied_cells_ = 0;
};

}  // namespace slam2d
