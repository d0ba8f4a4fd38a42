#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "viewer/data/points/page_book.hpp"
#include "viewer/data/value_range.hpp"
#include "viewer/scene/gl/gl_object.hpp"
#include "viewer/scene/gl/slice.hpp"
#include "viewer/scene/layers/nearest_point.hpp"
#include "viewer/scene/layers/point_programs.hpp"

namespace hgros::viewer {

/// Points that are kept forever: 4 bytes each on the GPU, 1 more for a value, 2 more for a color, and nothing on the
/// CPU. Memory is allocated in slabs, so that nothing is copied when it grows. Thread: the one whose GL context is
/// current.
class KeptPoints {
 public:
  /// `cell_meters` is that of PageBook. Only the requested parts are stored.
  KeptPoints(double cell_meters, bool with_values, bool with_colors);

  /// Adds the points of a message. `values` and `colors` are as long as `positions`, or unused. Colors have red in the
  /// lowest byte.
  void Add(std::span<const Eigen::Vector3d> positions, std::span<const float> values,
           std::span<const std::uint32_t> colors);

  /// Draws what was added since the last call.
  void DrawNew(PointPrograms& programs, const ViewMatrices& view, const PointStyle& style);
  void Draw(PointPrograms& programs, const ViewMatrices& view, const PointStyle& style, const Slice& slice);
  /// Searches for a point closer to `at`. Reads points back from the GPU.
  void Find(const Eigen::Vector3d& at, NearestPoint& nearest) const;

  [[nodiscard]] std::size_t points() const noexcept { return book_.points(); }
  [[nodiscard]] std::size_t gpu_bytes() const noexcept;
  /// BoundsOfMost of the messages that were added.
  [[nodiscard]] Eigen::AlignedBox3d Bounds() const;
  [[nodiscard]] const ValueRange& values() const noexcept { return range_; }
  [[nodiscard]] bool with_values() const noexcept { return with_values_; }
  [[nodiscard]] bool with_colors() const noexcept { return with_colors_; }

 private:
  static constexpr std::size_t kSlabPages = 512;
  static constexpr std::size_t kSlabPoints = kSlabPages * PageBook::kPagePoints;

  struct Slab {
    GlBuffer codes;
    GlBuffer values;
    GlBuffer colors;
    GlBuffer pages;
    GlTexture page_texture;
    Eigen::Vector3d origin;
    Eigen::AlignedBox3d bounds;
    std::size_t used_pages = 0;
    std::vector<GLint> new_firsts;  ///< Runs that DrawNew has not drawn yet.
    std::vector<GLsizei> new_counts;
  };

  /// Messages that are near each other. One box for each message would need memory without end.
  struct Region {
    Eigen::AlignedBox3d box;
    std::size_t messages = 0;
  };

  void AddToRegion(std::span<const Eigen::Vector3d> positions);
  void BeginPages(std::size_t first, std::span<const Eigen::Vector3d> corners);
  [[nodiscard]] Slab MakeSlab(const Eigen::Vector3d& origin) const;
  void Recode(const ValueRange& before);
  /// Prepares drawing of every `stride`-th point, starting at `first`.
  void Bind(PointPrograms& programs, ShaderProgram& program, const ViewMatrices& view, const PointStyle& style,
            const Slab& slab, const Slice& slice);

  PageBook book_;
  const bool with_values_;
  const bool with_colors_;
  ValueRange range_;
  std::vector<Region> regions_;
  std::size_t messages_ = 0;  ///< Of all regions.
  std::vector<Slab> slabs_;
  GlVertexArray vertices_;
};

}  // namespace hgros::viewer
