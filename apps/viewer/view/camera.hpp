#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "hgros/tf/rigid_transform.hpp"

namespace hgros::viewer {

/// Pixels of the picture; places in it are counted from the upper left corner.
struct Viewport {
  int width = 1;
  int height = 1;
  bool operator==(const Viewport&) const = default;
};

/// What the GPU needs of a camera. Everything is drawn relative to the eye, so that coordinates of 10^6 m and more stay
/// exact: positions go to the GPU as float differences to it.
struct ViewMatrices {
  Eigen::Matrix4f clip_from_eye;  ///< From world axes with the eye as origin.
  Eigen::Vector3d eye;            ///< In the fixed frame.
  Viewport viewport;
  float pixels_per_metre_at_1m = 1;  ///< Orthographic: everywhere.
  bool orthographic = false;
};

/// Where the view is taken from. The world has z up; the camera looks along its own -z, y is up in the picture.
///
/// It turns about and zooms towards the pivot: the anchor if one was picked, else the point in the middle of the
/// picture at distance(). Metres, radians, pixels; double throughout.
class Camera {
 public:
  Camera();

  /// Turns about the pivot: `yaw` about the world's z, then `pitch` about the picture's x. The horizon stays level, and
  /// the pitch ends at the poles.
  void Orbit(double yaw, double pitch);
  /// Turns about the pivot and the picture's own axes, without a limit.
  void Turn(double roll, double pitch, double yaw);
  /// Moves so that what lies at the pivot's depth follows the pointer.
  void Pan(double dx_pixels, double dy_pixels, const Viewport& viewport);
  /// Goes nearer by `factor` (> 1) or further away; what is under the pixel (or the anchor) stays there in the picture.
  void Zoom(double factor, double x_pixels, double y_pixels, const Viewport& viewport);
  /// Moves eye and anchor along the picture's x, y and the direction of view.
  void Move(const Eigen::Vector3d& right_up_forward);

  void SetAnchor(const std::optional<Eigen::Vector3d>& anchor);
  /// Straight down at the pivot, with x to the right and y up in the picture.
  void LookFromAbove();
  /// Looks at a point from the direction and distance that the camera has.
  void Center(const Eigen::Vector3d& at);
  /// Looks at a sphere so that it fills the picture, from the direction that the camera has.
  void Focus(const Eigen::Vector3d& center, double radius);
  /// Likewise at a box, of which the picture shows all and little else. What is not finite is not looked at.
  void Focus(const Eigen::AlignedBox3d& box, const Viewport& viewport);
  void SetOrthographic(bool orthographic) { orthographic_ = orthographic; }
  void Reset() { *this = Camera(); }
  /// Puts it where one was before: eye(), orientation() and distance(). The quaternion need not be of unit length.
  void Place(const Eigen::Vector3d& eye, const Eigen::Quaterniond& orientation, double distance);
  /// Takes eye and anchor along with something that has moved: with its whole pose, or its position alone.
  void Follow(const RigidTransform& before, const RigidTransform& now, bool with_rotation);

  [[nodiscard]] ViewMatrices Matrices(const Viewport& viewport) const;
  /// The point that is seen at a pixel with a depth from the depth buffer, 0 to 1.
  [[nodiscard]] Eigen::Vector3d PointAt(double x_pixels, double y_pixels, double depth, const Viewport& viewport) const;
  /// Where a point is seen, in pixels, and its depth; none if it lies behind the eye.
  [[nodiscard]] std::optional<Eigen::Vector3d> PixelOf(const Eigen::Vector3d& point, const Viewport& viewport) const;

  [[nodiscard]] const Eigen::Vector3d& eye() const noexcept { return eye_; }
  [[nodiscard]] const Eigen::Quaterniond& orientation() const noexcept { return orientation_; }  ///< Of the camera.
  [[nodiscard]] double distance() const noexcept { return distance_; }
  [[nodiscard]] bool orthographic() const noexcept { return orthographic_; }
  [[nodiscard]] const std::optional<Eigen::Vector3d>& anchor() const noexcept { return anchor_; }
  [[nodiscard]] Eigen::Vector3d Pivot() const;
  [[nodiscard]] bool SameViewAs(const Camera& other) const;

 private:
  [[nodiscard]] Eigen::Matrix4d Projection(const Viewport& viewport) const;
  [[nodiscard]] double NearPlane() const;
  /// Metres in the plane at `depth` that one pixel covers.
  [[nodiscard]] double MetresPerPixel(double depth, const Viewport& viewport) const;
  void TurnAbout(const Eigen::Vector3d& pivot, const Eigen::Quaterniond& turn);

  Eigen::Vector3d eye_;
  Eigen::Quaterniond orientation_;
  double distance_ = 20;  ///< To the middle of what is looked at; the size of an orthographic picture, too.
  bool orthographic_ = false;
  std::optional<Eigen::Vector3d> anchor_;
};

}  // namespace hgros::viewer
