#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <span>
#include <vector>

#include "viewer/data/points/packed_points.hpp"
#include "viewer/scene/gl/gl_object.hpp"
#include "viewer/scene/gl/slice.hpp"
#include "viewer/scene/gl/stream_buffer.hpp"
#include "viewer/scene/layers/nearest_point.hpp"
#include "viewer/scene/layers/point_programs.hpp"

namespace hgros::viewer {

/// The points of the last messages: 8 bytes each, and 4 more for a color. Each message has its own memory, which is
/// reused when the message is dropped. Thread: the one whose GL context is current.
class RecentPoints {
 public:
  /// `when_s` is on the same clock as the times of Expire.
  void Add(const PlacedPoints& positions, std::span<const float> values, std::span<const std::uint32_t> colors,
           double when_s);
  /// Keeps at most the last `messages`, and none from before `oldest_s`. Returns whether any were removed.
  bool Expire(std::size_t messages, double oldest_s);
  void Clear();

  /// Draws those that arrived no later than `until_s`.
  void Draw(PointPrograms& programs, const ViewMatrices& view, const PointStyle& style, const Slice& slice,
            double until_s);
  /// Searches these for a point closer to `at`. Reads them back from the GPU.
  void Find(const Eigen::Vector3d& at, double until_s, NearestPoint& nearest) const;

  [[nodiscard]] std::size_t points() const noexcept { return points_; }
  [[nodiscard]] std::size_t messages() const noexcept { return messages_.size(); }
  [[nodiscard]] std::size_t gpu_bytes() const noexcept;
  [[nodiscard]] Eigen::AlignedBox3d Bounds() const;
  /// When the oldest message arrived; infinity if there is none.
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
