#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace hgros::viewer {

/// A point that somebody has pointed at.
struct PickedPoint {
  Eigen::Vector3d at = Eigen::Vector3d::Zero();  ///< In the fixed frame.
  std::string display;                           ///< Empty: unknown.
  std::string frame;                             ///< That its data came in; empty: unknown, or the fixed one.
  std::optional<Eigen::Vector3d> in_frame;       ///< The point there.
  std::string value;                             ///< What there is to say of it; may be empty.
};

/// How two points lie to each other, in metres.
struct Measurement {
  Eigen::Vector3d step = Eigen::Vector3d::Zero();  ///< From the first to the second.
  double distance = 0;
  double in_plane = 0;  ///< Of the distance, what lies in x and y.
};

/// The points that were picked last: one, or two that are measured. A third one begins anew.
class PointPicks {
 public:
  void Add(PickedPoint point);
  void Clear() { points_.clear(); }
  [[nodiscard]] const std::vector<PickedPoint>& points() const noexcept { return points_; }
  /// Once there are two.
  [[nodiscard]] std::optional<Measurement> measurement() const;

 private:
  std::vector<PickedPoint> points_;
};

/// "x, y, z m" with as many places as the size of the numbers leaves sense for: millimetres up to a kilometre.
[[nodiscard]] std::string MetresText(const Eigen::Vector3d& at);
[[nodiscard]] std::string MetresText(double length);

}  // namespace hgros::viewer
