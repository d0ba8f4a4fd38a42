#include "correlative_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace slam2d {
namespace {

constexpr std::size_t kLevels = LikelihoodField::kLevels;

// A square of translations at one angle: stride x stride cells from (x, y), as offsets from the window's corner.
struct Block {
  double bound = 0.0;
  int angle = 0;
  int y = 0;
  int x = 0;
};

// Best bound first. Ties follow the order of the grid, so that the search is the same on every machine.
bool Before(const Block& a, const Block& b) {
  if (a.bound != b.bound) return a.bound > b.bound;
  if (a.angle != b.angle) return a.angle < b.angle;
  if (a.y != b.y) return a.y < b.y;
  return a.x < b.x;
}

bool InGridOrder(const Block& a, const Block& b) {
  if (a.angle != b.angle) return a.angle < b.angle;
  if (a.y != b.y) return a.y < b.y;
  return a.x < b.x;
}

class Search {
 public:
  Search(const LikelihoodField& field, const std::vector<Point2>& points, const Pose2& center,
         const SearchWindow& window)
      : field_(field),
        points_(points),
        center_(center),
        window_(window),
        half_cells_(static_cast<int>(std::lround(window.half_width_m / field.cell_size_m()))),
        half_angles_(static_cast<int>(std::lround(window.half_angle_rad / window.angle_step_rad))),
        edge_(2 * half_cells_ + 1) {
    for (auto& bases : bases_) bases.resize(static_cast<std::size_t>(2 * half_angles_ + 1));
  }

  SearchResult Run(double min_score) {
    best_.bound = min_score;
    const std::size_t top = edge_ > 4 * LikelihoodField::kStride[1] ? 2 : 1;
    const int stride = LikelihoodField::kStride[top];
    std::vector<Block> blocks;
    for (int a = 0; a <= 2 * half_angles_; ++a) {
      PlacePoints(a);
      for (int y = 0; y < edge_; y += stride) {
        for (int x = 0; x < edge_; x += stride) AddBlock({0.0, a, y, x}, top, blocks);
      }
    }
    Visit(blocks, top);
    if (!found_) return {center_, -1.0};
    const double cell = field_.cell_size_m();
    return {{center_.x + (best_.x - half_cells_) * cell, center_.y + (best_.y - half_cells_) * cell,
             WrapAngle(center_.theta + Angle(best_.angle))},
            best_.bound};
  }

 private:
  [[nodiscard]] double Angle(int a) const { return (a - half_angles_) * window_.angle_step_rad; }

  // For every level: the index in its values of each point, moved by the window's corner.
  void PlacePoints(int a) {
    const double cells_per_m = 1.0 / field_.cell_size_m();
    const double c = std::cos(center_.theta + Angle(a)) * cells_per_m;
    const double s = std::sin(center_.theta + Angle(a)) * cells_per_m;
    const double center_x = center_.x * cells_per_m;
    const double center_y = center_.y * cells_per_m;
    const LikelihoodField::Level& fine = field_.level(0);
    for (auto& bases : bases_) bases[static_cast<std::size_t>(a)].reserve(points_.size());
    for (const Point2& p : points_) {
      const int x = static_cast<int>(std::floor(center_x + c * p.x - s * p.y)) - half_cells_;
      const int y = static_cast<int>(std::floor(center_y + s * p.x + c * p.y)) - half_cells_;
      // The last coarse block may extend over the window's edge.
      if (!fine.Holds(x, y) || !fine.Holds(x + edge_ + 16, y + edge_ + 16)) continue;
      for (std::size_t l = 0; l < kLevels; ++l) {
        const int shift = 2 * static_cast<int>(l);
        bases_[l][static_cast<std::size_t>(a)].push_back(
            static_cast<std::uint32_t>(field_.level(l).Index(x >> shift, y >> shift)));
      }
    }
  }

  void AddBlock(Block block, std::size_t l, std::vector<Block>& blocks) const {
    const int stride = LikelihoodField::kStride[l];
    const LikelihoodField::Level& level = field_.level(l);
    const auto offset = static_cast<std::uint32_t>(block.y / stride * level.width + block.x / stride);
    const std::uint8_t* values = level.values.data() + offset;
    std::uint32_t sum = 0;
    for (const std::uint32_t base : bases_[l][static_cast<std::size_t>(block.angle)]) sum += values[base];
    block.bound = sum / (255.0 * static_cast<double>(points_.size())) - LeastCost(block, stride);
    if (block.bound >= best_.bound) blocks.push_back(block);
  }

  // The cost at the block's place nearest to the center.
  [[nodiscard]] double LeastCost(const Block& block, int stride) const {
    const double cell = field_.cell_size_m();
    const double dx = (std::clamp(half_cells_, block.x, block.x + stride - 1) - half_cells_) * cell;
    const double dy = (std::clamp(half_cells_, block.y, block.y + stride - 1) - half_cells_) * cell;
    const double angle = Angle(block.angle);
    return window_.cost_per_m2 * (dx * dx + dy * dy) + window_.cost_per_rad2 * angle * angle;
  }

  void Visit(std::vector<Block>& blocks, std::size_t l) {
    std::ranges::sort(blocks, Before);
    const int child_stride = l > 0 ? LikelihoodField::kStride[l - 1] : 0;
    for (const Block& block : blocks) {
      if (block.bound < best_.bound) return;
      if (l == 0) {
        if (found_ && block.bound == best_.bound && !InGridOrder(block, best_)) continue;
        best_ = block;
        found_ = true;
        continue;
      }
      std::vector<Block> children;
      for (int y = block.y; y < std::min(block.y + LikelihoodField::kStride[l], edge_); y += child_stride) {
        for (int x = block.x; x < std::min(block.x + LikelihoodField::kStride[l], edge_); x += child_stride) {
          AddBlock({0.0, block.angle, y, x}, l - 1, children);
        }
      }
      Visit(children, l - 1);
    }
  }

  const LikelihoodField& field_;
  const std::vector<Point2>& points_;
  const Pose2 center_;
  const SearchWindow window_;
  const int half_cells_;
  const int half_angles_;
  const int edge_;
  std::array<std::vector<std::vector<std::uint32_t>>, kLevels> bases_;
  Block best_;
  bool found_ = false;
};

}  // namespace

SearchResult SearchCorrelative(const LikelihoodField& field, const std::vector<Point2>& points,
                               const Pose2& T_map_center, const SearchWindow& window, double min_score) {
  if (points.empty() || field.empty()) return {T_map_center, -1.0};
  return Search(field, points, T_map_center, window).Run(min_score);
}

}  // namespace slam2d
