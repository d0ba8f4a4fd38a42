#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "viewer/data/frames/fixed_frame.hpp"
#include "viewer/data/points/page_book.hpp"
#include "viewer/scene/gl/gl_object.hpp"
#include "viewer/scene/gl/slice.hpp"
#include "viewer/scene/layers/nearest_point.hpp"
#include "viewer/scene/layers/point_programs.hpp"

namespace hgros::viewer {

/// Points that are kept forever: 4 bytes each on the GPU, 1 more for a value, 2 more for a color, and nothing on the
/// CPU. They have the coordinates of the fixed frame in which they came. Memory is allocated in slabs, so that nothing
/// is copied when it grows. Thread: the one whose GL context is current.
class KeptPoints {
 public:
  /// `frame` is the fixed frame. Only the requested parts are stored.
  KeptPoints(std::string frame, bool with_values, bool with_colors);

  /// Adds the points of a message. `values` and `colors` are as long as `positions`, or unused. Colors have red in the
  /// lowest byte.
  void Add(std::span<const Eigen::Vector3d> positions, std::span<const float> values,
           std::span<const std::uint32_t> colors);
  /// Call it when the fixed frame or a transform has changed. In another fixed frame, all points move to the place that
  /// their old one has there now, and stay. Until it is known, they are not shown, and `why_not` says why. Returns
  /// whether they were placed.
  bool PlaceAgain(const FixedFrame& fixed, bool frame_changed, std::string& why_not);

  /// Draws what was added since the last call.
  void DrawNew(PointPrograms& programs, const ViewMatrices& view, const PointStyle& style);
  void Draw(PointPrograms& programs, const ViewMatrices& view, const PointStyle& style, const Slice& slice);
  /// Searches for a point closer to `at`. Reads points back from the GPU.
  void Find(const Eigen::Vector3d& at, NearestPoint& nearest) const;

  [[nodiscard]] std::size_t points() const noexcept { return book_.points(); }
  [[nodiscard]] std::size_t messages() const noexcept { return messages_; }
  [[nodiscard]] std::size_t gpu_bytes() const noexcept;
  [[nodiscard]] const std::string& frame() const noexcept { return frame_; }
  /// BoundsOfMost of the messages that were added.
  [[nodiscard]] Eigen::AlignedBox3d Bounds() const;

 private:
  static constexpr std::size_t kSlabPages = 512;
  static constexpr std::size_t kSlabPoints = kSlabPages * PageBook::kPagePoints;

  /// Corner and edge of the page's cell, its lowest and highest value, and two unused numbers.
  using PageRow = std::array<float, 8>;

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

  /// The limits of the 8 bits of a value.
  struct Range {
    float lowest = 0;
    float highest = 1;
  };

  void AddToRegion(const Eigen::AlignedBox3d& box);
  /// Index of the range for the values of a message. It is one of an earlier message if that has the values without
  /// outliers, and is not more than four times as wide. So absurd values of one message take no precision from others.
  [[nodiscard]] std::size_t RangeFor(std::span<const float> values);
  /// `middle` becomes the origin of new slabs: floats are exact near it.
  void BeginPages(std::size_t first, std::span<const PageBook::Page> pages, const Range& range,
                  const Eigen::Vector3d& middle);
  [[nodiscard]] Slab MakeSlab(const Eigen::Vector3d& origin) const;
  /// Prepares drawing of every `stride`-th point, starting at `first`.
  void Bind(PointPrograms& programs, ShaderProgram& program, const ViewMatrices& view, const PointStyle& style,
            const Slab& slab, const Slice& slice);

  const std::string frame_;
  std::optional<RigidTransform> fixed_from_kept_ = RigidTransform();
  PageBook book_;
  const bool with_values_;
  const bool with_colors_;
  std::vector<Range> ranges_;  ///< Of the values in pages that are not full.
  std::vector<Region> regions_;
  std::size_t messages_ = 0;  ///< Of all regions.
  std::vector<Slab> slabs_;
  GlVertexArray vertices_;
};

}  // namespace hgros::viewer
