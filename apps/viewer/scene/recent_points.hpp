#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <span>
#include <vector>

#include "viewer/data/packed_points.hpp"
#include "viewer/scene/gl_object.hpp"
#include "viewer/scene/nearest_point.hpp"
#include "viewer/scene/point_programs.hpp"
#include "viewer/scene/slice.hpp"
#include "viewer/scene/stream_buffer.hpp"

namespace hgros::viewer {

/// The points of the last messages, 8 bytes each and 4 more for a colour. Each message has memory of its own, and that
/// of one which has gone is used for the next. Thread: the one whose GL context is current.
class RecentPoints {
 public:
  /// `when_s` on the clock that Expire goes by.
  void Add(const PlacedPoints& positions, std::span<const float> values, std::span<const std::uint32_t> colors,
           double when_s);
  /// Keeps at most the last `messages`, none from before `oldest_s`. Whether some have gone.
  bool Expire(std::size_t messages, double oldest_s);
  void Clear();

  /// Those that came no later than `until_s`.
  void Draw(PointPrograms& programs, const ViewMatrices& view, const PointStyle& style, const Slice& slice,
            double until_s);
  /// Looks for a point nearer to `at` among those. Reads them back from the GPU.
  void Find(const Eigen::Vector3d& at, double until_s, NearestPoint& nearest) const;

  [[nodiscard]] std::size_t points() const noexcept { return points_; }
  [[nodiscard]] std::size_t messages() const noexcept { return messages_.size(); }
  [[nodiscard]] std::size_t gpu_bytes() const noexcept;
  [[nodiscard]] Eigen::AlignedBox3d Bounds() const;
  /// When the oldest came; infinity if there is none.
  [[nodiscard]] double oldest_s() const noexcept;

 private:
  struct Message {
    StreamBuffer points;
    StreamBuffer colors;
    std::size_t count = 0;
    bool has_values = false;
    bool has_colors = false;
    PackedBox box;
    double when_s = 0;
  };

  std::deque<Message> messages_;
  std::vector<Message> spare_;
  std::size_t points_ = 0;
  GlVertexArray vertices_;
};

}  // namespace hgros::viewer
