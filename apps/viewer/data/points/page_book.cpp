#include "viewer/data/points/page_book.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "viewer/data/points/cell_code.hpp"

namespace hgros::viewer {
namespace {

constexpr double kExactCellMeters = 16;

}  // namespace

std::size_t PageBook::CellHash::operator()(const Cell& cell) const noexcept {
  std::uint64_t mixed = static_cast<std::uint64_t>(cell.x) * 0x9E3779B97F4A7C15U;
  mixed = (mixed ^ static_cast<std::uint64_t>(cell.y)) * 0xC2B2AE3D27D4EB4FU;
  mixed = (mixed ^ static_cast<std::uint64_t>(cell.z)) * 0x165667B19E3779F9U;
  mixed ^= std::bit_cast<std::uint64_t>(cell.edge_meters) + cell.kind;
  return static_cast<std::size_t>(mixed ^ mixed >> 29U);
}

PageBook::Added PageBook::Add(std::span<const Eigen::Vector3d> positions, const Eigen::AlignedBox3d& box,
                              std::size_t kind) {
  const auto cell_for = [](const Eigen::AlignedBox3d& all) {
    return CellFor(all.isEmpty() ? 0 : all.sizes().maxCoeff());
  };
  extent_.extend(box);
  // One message that is far from all others makes no larger cells for them.
  if (const double wanted = std::min(cell_for(extent_), kExactCellMeters); wanted > cell_meters_) {
    cell_meters_ = wanted;
    ClosePages();
  }
  const double usual_edge = std::max(cell_meters_, cell_for(box));
  // Counting sort by cell: a message has far fewer cells than points.
  struct Touched {
    Cell cell;
    Open* open;
    std::size_t count = 0;
    std::size_t next = 0;
  };
  ++adds_;
  std::vector<Touched> touched;
  std::vector<std::uint32_t> cell_of(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    double edge = usual_edge;
    if (!box.contains(positions[i])) {
      const double distance = (positions[i] - box.center()).cwiseAbs().maxCoeff();
      edge = std::max(edge, std::exp2(std::ceil(std::log2(distance))));
    }
    const Eigen::Vector3d scaled = positions[i] / edge;
    const Cell cell{static_cast<std::int64_t>(std::floor(scaled.x())),
                    static_cast<std::int64_t>(std::floor(scaled.y())),
                    static_cast<std::int64_t>(std::floor(scaled.z())), edge, kind};
    // Neighbors in a message are mostly neighbors in space.
    const bool same = i > 0 && touched[cell_of[i - 1]].cell == cell;
    Open& open = same ? *touched[cell_of[i - 1]].open : cells_[cell];
    if (open.add != adds_) {
      open.add = adds_;
      open.latest = touched.size();
      touched.push_back({cell, &open});
    }
    cell_of[i] = static_cast<std::uint32_t>(open.latest);
    ++touched[open.latest].count;
  }

  Added added;
  added.codes.resize(positions.size());
  added.order.resize(positions.size());
  std::size_t from = 0;
  for (Touched& at : touched) {
    at.next = from;
    for (std::size_t left = at.count; left > 0;) {
      if (at.open->used == kPagePoints) {
        at.open->page = pages_++;
        at.open->used = 0;
        added.new_pages.push_back({at.cell.Corner(), at.cell.edge_meters});
      }
      const std::size_t count = std::min(left, kPagePoints - at.open->used);
      added.runs.push_back({at.open->page, at.open->used, from, count});
      at.open->used += count;
      from += count;
      left -= count;
    }
  }
  for (std::size_t i = 0; i < positions.size(); ++i) {
    Touched& at = touched[cell_of[i]];
    added.codes[at.next] = cell_code::Encode((positions[i] - at.cell.Corner()) / at.cell.edge_meters);
    added.order[at.next] = static_cast<std::uint32_t>(i);
    ++at.next;
  }
  points_ += positions.size();
  return added;
}

double PageBook::CellFor(double extent_meters) {
  const double wanted = std::clamp(extent_meters / 8, 0.0625, std::max(kExactCellMeters, extent_meters / 64));
  return std::exp2(std::round(std::log2(wanted)));
}

}  // namespace hgros::viewer
