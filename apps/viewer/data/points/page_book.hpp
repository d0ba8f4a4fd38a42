#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

namespace hgros::viewer {

/// Assigns kept points to pages. Space is divided into cells, and each cell fills pages of equal size, so that a point
/// costs 4 bytes (cell_code) plus its color, and is never moved. Cells grow with the space that is used, and with the
/// distance of outliers, so that there are few pages with little in them. Pages are numbered in the order in which they
/// begin. The owner of the GPU memory puts many pages into one buffer. The book remembers only where to continue
/// writing, not the points.
class PageBook {
 public:
  static constexpr std::size_t kPagePoints = 256;

  /// Consecutive points of one page, sorted by Add: `count` points starting at `from` in `codes` and `order`.
  struct Run {
    std::size_t page = 0;
    std::size_t slot = 0;  ///< Slot of the first point in the page.
    std::size_t from = 0;
    std::size_t count = 0;
  };
  struct Page {
    Eigen::Vector3d corner;  ///< The lower corner of its cell.
    double edge_meters = 0;
  };
  struct Added {
    std::vector<Run> runs;
    std::vector<std::uint32_t> codes;  ///< Code of each point, in the order of the runs.
    std::vector<std::uint32_t> order;  ///< Index of each point in the input.
    std::vector<Page> new_pages;       ///< Their numbers continue from the old pages().
  };

  /// `box` is around the positions, without outliers. They are exact to about 1/4000 of their cell (z: 1/2000), and
  /// outliers to 1/1000 of their distance from its middle. A page has only points of equal `kind`.
  [[nodiscard]] Added Add(std::span<const Eigen::Vector3d> positions, const Eigen::AlignedBox3d& box,
                          std::size_t kind = 0);
  /// Further points begin new pages.
  void ClosePages() noexcept { cells_.clear(); }

  [[nodiscard]] std::size_t pages() const noexcept { return pages_; }
  [[nodiscard]] std::size_t points() const noexcept { return points_; }
  [[nodiscard]] std::size_t cells() const noexcept { return cells_.size(); }

  /// The edge of cells for points spread over `extent_meters`: a power of two, so that steps are finer than 1/30000 of
  /// the extent, and at most 16 m up to 1 km, so that positions are exact to 1 cm there. Above, 1/64 of the extent.
  [[nodiscard]] static double CellFor(double extent_meters);

 private:
  struct Cell {
    std::int64_t x;
    std::int64_t y;
    std::int64_t z;
    double edge_meters;
    std::size_t kind;
    [[nodiscard]] Eigen::Vector3d Corner() const noexcept {
      return Eigen::Vector3d(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)) * edge_meters;
    }
    bool operator==(const Cell&) const = default;
  };
  struct CellHash {
    std::size_t operator()(const Cell& cell) const noexcept;
  };
  struct Open {
    std::size_t page = 0;
    std::size_t used = kPagePoints;  ///< Used points of the page. Full at first, so that the first point begins a page.
    std::size_t latest = 0;          ///< The run that collects the cell's points during this Add.
    std::uint64_t add = 0;
  };

  double cell_meters_ = 0;  ///< The least edge of the cells of new pages.
  Eigen::AlignedBox3d extent_;
  std::unordered_map<Cell, Open, CellHash> cells_;
  std::size_t pages_ = 0;
  std::size_t points_ = 0;
  std::uint64_t adds_ = 0;
};

}  // namespace hgros::viewer
