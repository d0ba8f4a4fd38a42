#pragma once

#include <cmath>
#include <numbers>

namespace slam2d {

/// The same angle in [-pi, pi].
[[nodiscard]] inline double WrapAngle(double angle_rad) { return std::remainder(angle_rad, 2.0 * std::numbers::pi); }

/// A point or displacement in the plane, m.
struct Point2 {
  double x = 0.0;
  double y = 0.0;

  friend bool operator==(const Point2&, const Point2&) = default;
};

/// Rigid motion of the plane, an element of SE(2). `T_target_source` rotates by `theta`, then translates by (x, y).
/// Also the pose of a frame `source` in a frame `target`. x and y in m, theta in rad, wrapped by every operation.
struct Pose2 {
  double x = 0.0;
  double y = 0.0;
  double theta = 0.0;

  friend bool operator==(const Pose2&, const Pose2&) = default;
};

/// T_a_c = T_a_b * T_b_c.
[[nodiscard]] inline Pose2 operator*(const Pose2& T_a_b, const Pose2& T_b_c) {
  const double c = std::cos(T_a_b.theta);
  const double s = std::sin(T_a_b.theta);
  return {T_a_b.x + c * T_b_c.x - s * T_b_c.y, T_a_b.y + s * T_b_c.x + c * T_b_c.y,
          WrapAngle(T_a_b.theta + T_b_c.theta)};
}

/// p_target = T_target_source * p_source.
[[nodiscard]] inline Point2 operator*(const Pose2& T_target_source, const Point2& p_source) {
  const double c = std::cos(T_target_source.theta);
  const double s = std::sin(T_target_source.theta);
  return {T_target_source.x + c * p_source.x - s * p_source.y, T_target_source.y + s * p_source.x + c * p_source.y};
}

/// T_source_target.
[[nodiscard]] inline Pose2 Inverse(const Pose2& T_target_source) {
  const double c = std::cos(T_target_source.theta);
  const double s = std::sin(T_target_source.theta);
  return {-c * T_target_source.x - s * T_target_source.y, s * T_target_source.x - c * T_target_source.y,
          WrapAngle(-T_target_source.theta)};
}

/// Length of the translation of `T`, m.
[[nodiscard]] inline double Distance(const Pose2& T) { return std::hypot(T.x, T.y); }

}  // namespace slam2d
