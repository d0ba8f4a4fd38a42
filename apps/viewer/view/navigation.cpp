#include "viewer/view/navigation.hpp"

#include <cmath>
#include <numbers>

namespace hgros::viewer {
namespace {

constexpr double kClickPixels = 4;  // A shorter drag is a click.
constexpr double kRadiansPerPixel = 0.006;
constexpr double kZoomPerStep = 1.15;
constexpr double kKeyRadians = std::numbers::pi / 60;
constexpr double kKeyMove = 0.05;  // of the distance

}  // namespace

void Navigation::OnPress(PointerButton button, double x, double y) {
  if (held_) return;
  held_ = button;
  pressed_at_ = at_ = Eigen::Vector2d(x, y);
  moved_ = false;
}

std::optional<Eigen::Vector2d> Navigation::OnRelease(PointerButton button, double x, double y) {
  if (held_ != button) return std::nullopt;
  held_.reset();
  if (button != PointerButton::kLeft || moved_) return std::nullopt;
  return Eigen::Vector2d(x, y);
}

void Navigation::OnPointer(double x, double y, const Viewport& viewport) {
  const Eigen::Vector2d now(x, y);
  const Eigen::Vector2d step = now - at_;
  if (!held_) {
    at_ = now;
    return;
  }
  if (!moved_ && (now - pressed_at_).norm() < kClickPixels) return;  // A drag counts from its beginning.
  moved_ = true;
  at_ = now;
  if (*held_ == PointerButton::kLeft) {
    camera_.Orbit(-step.x() * kRadiansPerPixel, -step.y() * kRadiansPerPixel);
  } else {
    camera_.Pan(step.x(), step.y(), viewport);
  }
}

void Navigation::OnWheel(double steps, const Viewport& viewport) {
  camera_.Zoom(std::pow(kZoomPerStep, steps), at_.x(), at_.y(), viewport);
}

void Navigation::OnKey(CameraKey key) {
  const double step = kKeyMove * camera_.distance();
  switch (key) {
    case CameraKey::kYawLeft: return camera_.Turn(0, 0, -kKeyRadians);
    case CameraKey::kYawRight: return camera_.Turn(0, 0, kKeyRadians);
    case CameraKey::kPitchUp: return camera_.Turn(0, -kKeyRadians, 0);
    case CameraKey::kPitchDown: return camera_.Turn(0, kKeyRadians, 0);
    case CameraKey::kRollLeft: return camera_.Turn(kKeyRadians, 0, 0);
    case CameraKey::kRollRight: return camera_.Turn(-kKeyRadians, 0, 0);
    case CameraKey::kForward: return camera_.Move({0, 0, step});
    case CameraKey::kBack: return camera_.Move({0, 0, -step});
    case CameraKey::kLeft: return camera_.Move({-step, 0, 0});
    case CameraKey::kRight: return camera_.Move({step, 0, 0});
    case CameraKey::kUp: return camera_.Move({0, step, 0});
    case CameraKey::kDown: return camera_.Move({0, -step, 0});
    case CameraKey::kFromAbove: return camera_.LookFromAbove();
    case CameraKey::kOrthographic: return camera_.SetOrthographic(!camera_.orthographic());
    case CameraKey::kReset: return camera_.Reset();
    case CameraKey::kClearAnchor: return camera_.SetAnchor(std::nullopt);
  }
}

}  // namespace hgros::viewer
