#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace hgros::viewer {

/// A point that was picked.
struct PickedPoint {
  Eigen::Vector3d at = Eigen::Vector3d::Zero();  ///< In the fixed frame.
  std::string display;                           ///< Empty: unknown.
  std::string frame;                             ///< The frame of its data. Empty: unknown, or the fixed frame.
  std::optional<Eigen::Vector3d> in_frame;       ///< The point in `frame`.
  std::string value;                             ///< Its value in words; may be empty.
};

/// The distance between two points, in meters.
struct Measurement {
  Eigen::Vector3d step = Eigen::Vector3d::Zero();  ///< From the first to the second.
  double distance = 0;
  double in_plane = 0;  ///< The distance in x and y only.
};

/// The last picked points: one, or two for a measurement. A third point starts again.
class PointPicks {
 public:
  void Add(PickedPoint point);
  void Clear() { points_.clear(); }
  [[nodiscard]] const std::vector<PickedPoint>& points() const noexcept { return points_; }
  /// None until there are two points.
  [[nodiscard]] std::optional<Measurement> measurement() const;

 private:
  std::vector<PickedPoint> points_;
};

/// "x, y, z m" with a number of decimals that suits their size: millimeters up to one kilometer.
[[nodiscard]] std::string MetersText(const Eigen::Vector3d& at);
[[nodiscard]] std::string MetersText(double length);

}  // namespace hgros::viewer
