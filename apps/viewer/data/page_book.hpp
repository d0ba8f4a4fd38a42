#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

namespace hgros::viewer {

/// Where kept points lie: space is divided into cells, and each cell fills pages of equal size, so that a point costs 4
/// bytes (cell_code) beside its colour, and nothing is ever moved. Pages are numbered through in the order in which
/// they are begun; whoever holds the memory (on the GPU) puts many of them into one buffer. The book itself keeps
/// where it goes on writing, not the points.
class PageBook {
 public:
  static constexpr std::size_t kPagePoints = 256;

  /// Consecutive points of one page, as sorted by Add: `count` of them from `from` on in `codes` and `order`.
  struct Run {
    std::size_t page = 0;
    std::size_t slot = 0;  ///< In the page, of the first.
    std::size_t from = 0;
    std::size_t count = 0;
  };
  struct Added {
    std::vector<Run> runs;
    std::vector<std::uint32_t> codes;        ///< Of each point, in the order of the runs.
    std::vector<std::uint32_t> order;        ///< Which of the points that were given it is.
    std::vector<Eigen::Vector3d> new_pages;  ///< Lower corners of the pages begun, from pages() as it was before.
  };

  /// `cell_metres` is the edge of a cell; positions are exact to about 1/4000 of it (z: 1/2000).
  explicit PageBook(double cell_metres) : cell_metres_(cell_metres) {}

  [[nodiscard]] Added Add(std::span<const Eigen::Vector3d> positions);

  [[nodiscard]] std::size_t pages() const noexcept { return pages_; }
  [[nodiscard]] std::size_t points() const noexcept { return points_; }
  [[nodiscard]] std::size_t cells() const noexcept { return cells_.size(); }
  [[nodiscard]] double cell_metres() const noexcept { return cell_metres_; }

  /// The edge that suits points spread over `extent_metres`: a power of two, so that steps are finer than a
  /// thirty-thousandth of it.
  [[nodiscard]] static double CellFor(double extent_metres);

 private:
  struct Cell {
    std::int64_t x;
    std::int64_t y;
    std::int64_t z;
    bool operator==(const Cell&) const = default;
  };
  struct CellHash {
    std::size_t operator()(const Cell& cell) const noexcept;
  };
  struct Open {
    std::size_t page = 0;
    std::size_t used = kPagePoints;  ///< Of its points; at first there is no page.
    std::size_t latest = 0;          ///< Where the cell's points of this Add are collected.
    std::uint64_t add = 0;
  };

  double cell_metres_;
  std::unordered_map<Cell, Open, CellHash> cells_;
  std::size_t pages_ = 0;
  std::size_t points_ = 0;
  std::uint64_t adds_ = 0;
};

}  // namespace hgros::viewer
