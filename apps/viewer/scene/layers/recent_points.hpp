#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "viewer/data/frames/fixed_frame.hpp"
#include "viewer/data/points/point_batch.hpp"
#include "viewer/data/points/point_boxes.hpp"
#include "viewer/scene/gl/gl_object.hpp"
#include "viewer/scene/gl/slice.hpp"
#include "viewer/scene/gl/stream_buffer.hpp"
#include "viewer/scene/layers/nearest_point.hpp"
#include "viewer/scene/layers/point_programs.hpp"

namespace hgros::viewer {

/// The points of the last messages, as they came: 12 bytes each, 4 more for a value, and 4 more for a color. Each
/// message has a place in the fixed frame, and its own memory, which is reused when the message is dropped. Thread: the
/// one whose GL context is current.
class RecentPoints {
 public:
  /// `when_s` is on the same clock as the times of Expire.
  void Add(const PointBatch& batch, const std::string& fixed_frame, const RigidTransform& T_fixed_frame, double when_s);
  /// Call it when the fixed frame or a transform has changed. Places all messages in another fixed frame by the
  /// transform at their stamp, or else by that of their old fixed frame now. Returns whether any were placed. `why_not`
  /// says why the last message could not be.
  bool PlaceAgain(const FixedFrame& fixed, bool frame_changed, std::string& why_not);
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
  /// BoundsOfMost of the messages that have a place.
  [[nodiscard]] Eigen::AlignedBox3d Bounds() const;
  /// When the oldest message arrived; infinity if there is none.
  [[nodiscard]] double oldest_s() const noexcept;

 private:
  struct Message {
    StreamBuffer points;  ///< Relative to the middle of the message's points.
    StreamBuffer values;
    StreamBuffer colors;
    std::size_t count = 0;
    bool has_values = false;
    bool has_colors = false;
    PointBoxes boxes;  ///< As `points`.
    std::string frame;
    Time stamp;
    RigidTransform T_frame_points;
    std::string fixed_frame;
    RigidTransform T_fixed_points;
    bool placed = true;  ///< `fixed_frame` is still the fixed frame.
    double when_s = 0;

    [[nodiscard]] std::size_t gpu_bytes() const noexcept {
      return points.capacity_bytes() + values.capacity_bytes() + colors.capacity_bytes();
    }
  };

  std::deque<Message> messages_;
  std::vector<Message> spare_;
  std::size_t points_ = 0;
  GlVertexArray vertices_;
};

}  // namespace hgros::viewer
