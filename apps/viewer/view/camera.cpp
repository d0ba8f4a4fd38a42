#include "viewer/view/camera.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace hgros::viewer {
namespace {

constexpr double kHalfAngle = std::numbers::pi / 8;  // 45 degrees from the bottom to the top of the picture
constexpr double kNearest = 1e-3;
constexpr double kFurthest = 1e7;
constexpr double kOutermost = 1e11;  // from the origin; the camera does not look at anything beyond it
constexpr double kDepthRatio = 1e5;  // far to near plane: 24 bits of depth resolve 1 cm at 100 m
constexpr double kSteepest = std::numbers::pi / 2 - 1e-3;

/// Looks along `forward` with a level horizon.
Eigen::Quaterniond LookAlong(const Eigen::Vector3d& forward, const Eigen::Vector3d& up) {
  Eigen::Matrix3d axes;
  axes.col(2) = -forward.normalized();
  axes.col(0) = up.cross(axes.col(2)).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return Eigen::Quaterniond(axes);
}

}  // namespace

Camera::Camera() : orientation_(LookAlong(Eigen::Vector3d(1, 0.6, -0.75), Eigen::Vector3d::UnitZ())) {
  eye_ = orientation_ * Eigen::Vector3d(0, 0, distance_);
}

Eigen::Vector3d Camera::Pivot() const {
  return anchor_ ? *anchor_ : eye_ + orientation_ * Eigen::Vector3d(0, 0, -distance_);
}

void Camera::TurnAbout(const Eigen::Vector3d& pivot, const Eigen::Quaterniond& turn) {
  eye_ = pivot + turn * (eye_ - pivot);
  orientation_ = (turn * orientation_).normalized();
}

void Camera::Orbit(double yaw, double pitch) {
  const Eigen::Vector3d pivot = Pivot();
  const Eigen::Vector3d forward = orientation_ * -Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d up = orientation_ * Eigen::Vector3d::UnitY();
  if (up.z() >= 0) {  // Not upside down: the pole is the limit.
    const double elevation = std::asin(std::clamp(forward.z(), -1.0, 1.0));
    pitch = std::clamp(pitch, std::min(0.0, -kSteepest - elevation), std::max(0.0, kSteepest - elevation));
  }
  TurnAbout(pivot, Eigen::Quaterniond(Eigen::AngleAxisd(pitch, orientation_ * Eigen::Vector3d::UnitX())));
  TurnAbout(pivot, Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ())));
}

void Camera::Turn(double roll, double pitch, double yaw) {
  const Eigen::Quaterniond in_picture = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitY()) *
                                        Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitX()) *
                                        Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ());
  TurnAbout(Pivot(), orientation_ * in_picture * orientation_.conjugate());
}

double Camera::MetersPerPixel(double depth, const Viewport& viewport) const {
  return 2 * std::tan(kHalfAngle) * (orthographic_ ? distance_ : depth) / viewport.height;
}

void Camera::Pan(double dx_pixels, double dy_pixels, const Viewport& viewport) {
  const Eigen::Vector3d forward = orientation_ * -Eigen::Vector3d::UnitZ();
  const double depth = std::max(forward.dot(Pivot() - eye_), 0.1 * distance_);
  const double scale = MetersPerPixel(depth, viewport);
  eye_ += orientation_ * Eigen::Vector3d(-dx_pixels * scale, dy_pixels * scale, 0);
}

void Camera::Zoom(double factor, double x_pixels, double y_pixels, const Viewport& viewport) {
  factor = std::clamp(factor, distance_ / kFurthest, distance_ / kNearest);
  const double keep = 1 / factor;
  Eigen::Vector3d toward = Pivot();
  if (!anchor_) {
    const double scale = MetersPerPixel(distance_, viewport);
    toward += orientation_ *
              Eigen::Vector3d((x_pixels - 0.5 * viewport.width) * scale, (0.5 * viewport.height - y_pixels) * scale, 0);
  }
  if (orthographic_) {
    Eigen::Vector3d offset = orientation_.conjugate() * (eye_ - toward);
    offset.x() *= keep;
    offset.y() *= keep;
    eye_ = toward + orientation_ * offset;
  } else {
    eye_ = toward + keep * (eye_ - toward);
  }
  distance_ *= keep;
}

void Camera::Move(const Eigen::Vector3d& right_up_forward) {
  const Eigen::Vector3d step =
      orientation_ * Eigen::Vector3d(right_up_forward.x(), right_up_forward.y(), -right_up_forward.z());
  eye_ += step;
  if (anchor_) *anchor_ += step;
}

void Camera::SetAnchor(const std::optional<Eigen::Vector3d>& anchor) {
  anchor_ = anchor;
  if (!anchor) return;
  // The depth planes and the steps of the keys depend on the distance to the pivot.
  const double depth = (orientation_ * -Eigen::Vector3d::UnitZ()).dot(*anchor - eye_);
  if (!orthographic_ && depth > kNearest) distance_ = depth;
}

void Camera::LookFromAbove() {
  const Eigen::Vector3d pivot = Pivot();
  orientation_ = Eigen::Quaterniond::Identity();
  eye_ = pivot + Eigen::Vector3d(0, 0, distance_);
}

void Camera::Center(const Eigen::Vector3d& at) {
  eye_ = at.cwiseMax(-kOutermost).cwiseMin(kOutermost) + orientation_ * Eigen::Vector3d(0, 0, distance_);
  anchor_.reset();
}

void Camera::Focus(const Eigen::Vector3d& center, double radius) {
  if (!center.allFinite() || !std::isfinite(radius)) return;
  distance_ = std::clamp(radius / std::tan(kHalfAngle), kNearest, kFurthest);
  Center(center);
}

void Camera::Focus(const Eigen::AlignedBox3d& box, const Viewport& viewport, const PixelArea& room) {
  if (box.isEmpty() || !box.center().allFinite() || !box.sizes().allFinite()) return;
  constexpr double kMargin = 1.1;
  constexpr double kSmallest = 0.5;
  const double per_pixel = 2 * std::tan(kHalfAngle) / viewport.height;  // at a depth of 1 m
  const double half_width = 0.5 * per_pixel * room.width;
  const double half_height = 0.5 * per_pixel * room.height;
  const double right_pixels = room.x + 0.5 * room.width - 0.5 * viewport.width;
  const double down_pixels = room.y + 0.5 * room.height - 0.5 * viewport.height;
  double distance = kSmallest;
  for (int i = 0; i < 8; ++i) {
    Eigen::Vector3d corner =
        orientation_.conjugate() * (box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i)) - box.center());
    if (!orthographic_) {  // Beside the middle of the picture, what is nearer is farther aside.
      corner.x() += per_pixel * right_pixels * corner.z();
      corner.y() -= per_pixel * down_pixels * corner.z();
    }
    const double half = kMargin * std::max(std::abs(corner.x()) / half_width, std::abs(corner.y()) / half_height);
    distance = std::max(distance, orthographic_ ? half : half + corner.z());
  }
  distance_ = std::min(distance, kFurthest);
  Center(box.center());
  Pan(right_pixels, down_pixels, viewport);
}

void Camera::Place(const Eigen::Vector3d& eye, const Eigen::Quaterniond& orientation, double distance) {
  eye_ = eye;
  orientation_ = orientation.normalized();
  distance_ = std::clamp(distance, kNearest, kFurthest);
}

void Camera::Follow(const RigidTransform& before, const RigidTransform& now, bool with_rotation) {
  const Eigen::Vector3d from = before.translation;
  const Eigen::Vector3d to = now.translation;
  const Eigen::Quaterniond turn =
      with_rotation ? Eigen::Quaterniond(now.rotation * before.rotation.conjugate()) : Eigen::Quaterniond::Identity();
  eye_ = to + turn * (eye_ - from);
  orientation_ = (turn * orientation_).normalized();
  if (anchor_) anchor_ = to + turn * (*anchor_ - from);
}

double Camera::NearPlane() const { return std::max(distance_ / 200, kNearest); }

Eigen::Matrix4d Camera::Projection(const Viewport& viewport) const {
  const double aspect = static_cast<double>(viewport.width) / viewport.height;
  Eigen::Matrix4d projection = Eigen::Matrix4d::Zero();
  if (orthographic_) {
    const double half_height = std::tan(kHalfAngle) * distance_;
    const double half_depth = std::max(100 * distance_, 1000.0);
    projection(0, 0) = 1 / (half_height * aspect);
    projection(1, 1) = 1 / half_height;
    projection(2, 2) = -1 / half_depth;  // Points behind the eye are visible, too.
    projection(3, 3) = 1;
    return projection;
  }
  const double near_plane = NearPlane();
  const double far_plane = near_plane * kDepthRatio;
  projection(1, 1) = 1 / std::tan(kHalfAngle);
  projection(0, 0) = projection(1, 1) / aspect;
  projection(2, 2) = -(far_plane + near_plane) / (far_plane - near_plane);
  projection(2, 3) = -2 * far_plane * near_plane / (far_plane - near_plane);
  projection(3, 2) = -1;
  return projection;
}

ViewMatrices Camera::Matrices(const Viewport& viewport) const {
  Eigen::Matrix4d turn = Eigen::Matrix4d::Identity();
  turn.topLeftCorner<3, 3>() = orientation_.conjugate().toRotationMatrix();
  ViewMatrices matrices;
  matrices.clip_from_eye = (Projection(viewport) * turn).cast<float>();
  matrices.eye = eye_;
  matrices.viewport = viewport;
  matrices.pixels_per_meter_at_1m = static_cast<float>(1 / MetersPerPixel(1, viewport));
  matrices.orthographic = orthographic_;
  return matrices;
}

Eigen::Vector3d Camera::PointAt(double x_pixels, double y_pixels, double depth, const Viewport& viewport) const {
  const Eigen::Vector4d clip(2 * x_pixels / viewport.width - 1, 1 - 2 * y_pixels / viewport.height, 2 * depth - 1, 1);
  const Eigen::Vector4d in_camera = Projection(viewport).inverse() * clip;
  return eye_ + orientation_ * (in_camera.head<3>() / in_camera.w());
}

std::optional<Eigen::Vector3d> Camera::PixelOf(const Eigen::Vector3d& point, const Viewport& viewport) const {
  Eigen::Vector4d in_camera;
  in_camera << orientation_.conjugate() * (point - eye_), 1;
  const Eigen::Vector4d clip = Projection(viewport) * in_camera;
  if (clip.w() <= 0) return std::nullopt;
  const Eigen::Vector3d unit = clip.head<3>() / clip.w();
  return Eigen::Vector3d((unit.x() + 1) / 2 * viewport.width, (1 - unit.y()) / 2 * viewport.height, (unit.z() + 1) / 2);
}

bool Camera::SameViewAs(const Camera& other) const {
  return eye_ == other.eye_ && orientation_.coeffs() == other.orientation_.coeffs() && distance_ == other.distance_ &&
         orthographic_ == other.orthographic_;
}

}  // namespace hgros::viewer
