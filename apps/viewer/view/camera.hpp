#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "hgros/tf/rigid_transform.hpp"

namespace hgros::viewer {

/// Size of the picture in pixels. Coordinates start at the upper left corner.
struct Viewport {
  int width = 1;
  int height = 1;
  bool operator==(const Viewport&) const = default;
};

/// A part of the picture, in pixels.
struct PixelArea {
  double x = 0;
  double y = 0;
  double width = 1;
  double height = 1;
};

/// The camera's data for the GPU. Positions go to the GPU as float differences from the eye, so that coordinates of
/// 10^6 m and more stay exact.
struct ViewMatrices {
  Eigen::Matrix4f clip_from_eye;  ///< From world axes with the origin at the eye.
  Eigen::Vector3d eye;            ///< In the fixed frame.
  Viewport viewport;
  float pixels_per_meter_at_1m = 1;  ///< Orthographic: everywhere.
  bool orthographic = false;
};

/// The camera. In the world, z points up. The camera looks along its own -z; its y points up in the picture.
///
/// It turns around the pivot and zooms toward it. The pivot is the anchor if there is one, or else the point in the
/// middle of the picture at distance(). Units: meters, radians, pixels.
class Camera {
 public:
  Camera();

  /// Turns around the pivot: `yaw` around the world's z, then `pitch` around the picture's x. The horizon stays level,
  /// and the pitch stops at the poles.
  void Orbit(double yaw, double pitch);
  /// Turns around the pivot, with the picture's own axes, without a limit.
  void Turn(double roll, double pitch, double yaw);
  /// Moves so that points at the pivot's depth follow the pointer.
  void Pan(double dx_pixels, double dy_pixels, const Viewport& viewport);
  /// Moves closer by `factor` (> 1) or away (< 1). The point under the pixel, or the anchor, stays in its place.
  void Zoom(double factor, double x_pixels, double y_pixels, const Viewport& viewport);
  /// Moves eye and anchor along the picture's x and y and the viewing direction.
  void Move(const Eigen::Vector3d& right_up_forward);

  void SetAnchor(const std::optional<Eigen::Vector3d>& anchor);
  /// Looks straight down at the pivot, with x to the right and y up in the picture.
  void LookFromAbove();
  /// Looks at a point with the same direction and distance.
  void Center(const Eigen::Vector3d& at);
  /// Looks at a sphere from the same direction, so that it fills the picture.
  void Focus(const Eigen::Vector3d& center, double radius);
  /// The same for a box. Ignores a box that is not finite. The box fills `room`, a part of the picture.
  void Focus(const Eigen::AlignedBox3d& box, const Viewport& viewport, const PixelArea& room);
  void Focus(const Eigen::AlignedBox3d& box, const Viewport& viewport) {
    Focus(box, viewport, {0, 0, static_cast<double>(viewport.width), static_cast<double>(viewport.height)});
  }
  void SetOrthographic(bool orthographic) { orthographic_ = orthographic; }
  void Reset() { *this = Camera(); }
  /// Places the camera by its eye(), orientation() and distance(). The quaternion is normalized.
  void Place(const Eigen::Vector3d& eye, const Eigen::Quaterniond& orientation, double distance);
  /// Moves eye and anchor along with an object that has moved: with its whole pose, or only with its position.
  void Follow(const RigidTransform& before, const RigidTransform& now, bool with_rotation);

  [[nodiscard]] ViewMatrices Matrices(const Viewport& viewport) const;
  /// The point at a pixel with a depth from the depth buffer, 0 to 1.
  [[nodiscard]] Eigen::Vector3d PointAt(double x_pixels, double y_pixels, double depth, const Viewport& viewport) const;
  /// Pixel and depth of a point. None if it is behind the eye.
  [[nodiscard]] std::optional<Eigen::Vector3d> PixelOf(const Eigen::Vector3d& point, const Viewport& viewport) const;

  [[nodiscard]] const Eigen::Vector3d& eye() const noexcept { return eye_; }
  /// Rotates from the camera to the world.
  [[nodiscard]] const Eigen::Quaterniond& orientation() const noexcept { return orientation_; }
  [[nodiscard]] double distance() const noexcept { return distance_; }
  [[nodiscard]] bool orthographic() const noexcept { return orthographic_; }
  [[nodiscard]] const std::optional<Eigen::Vector3d>& anchor() const noexcept { return anchor_; }
  [[nodiscard]] Eigen::Vector3d Pivot() const;
  [[nodiscard]] bool SameViewAs(const Camera& other) const;

 private:
  [[nodiscard]] Eigen::Matrix4d Projection(const Viewport& viewport) const;
  [[nodiscard]] double NearPlane() const;
  /// Size of one pixel in the plane at `depth`, in meters.
  [[nodiscard]] double MetersPerPixel(double depth, const Viewport& viewport) const;
  void TurnAbout(const Eigen::Vector3d& pivot, const Eigen::Quaterniond& turn);

  Eigen::Vector3d eye_;
  Eigen::Quaterniond orientation_;
  double distance_ = 20;  ///< To the point in the middle of the picture. Also sets the size of an orthographic picture.
  bool orthographic_ = false;
  std::optional<Eigen::Vector3d> anchor_;
};

}  // namespace hgros::viewer
