#pragma once

#include <optional>

#include "viewer/view/camera.hpp"

namespace hgros::viewer {

enum class PointerButton { kLeft, kRight, kMiddle };

/// A key's effect on the camera. The keys are in one table (panels/overlay/key_table.hpp).
enum class CameraKey {
  kYawLeft,
  kYawRight,
  kPitchUp,
  kPitchDown,
  kRollLeft,
  kRollRight,
  kForward,
  kBack,
  kLeft,
  kRight,
  kUp,
  kDown,
  kFromAbove,
  kOrthographic,
  kReset,
  kClearAnchor,
};

/// Moves a camera with mouse and keyboard: left drag orbits, right or middle drag pans, the wheel zooms, a left click
/// picks. Borrows the camera.
class Navigation {
 public:
  explicit Navigation(Camera& camera) : camera_(camera) {}

  void OnPress(PointerButton button, double x, double y);
  /// Returns the pixel of a click that picks; none otherwise.
  [[nodiscard]] std::optional<Eigen::Vector2d> OnRelease(PointerButton button, double x, double y);
  void OnPointer(double x, double y, const Viewport& viewport);
  /// `steps` of the wheel; positive: toward the scene.
  void OnWheel(double steps, const Viewport& viewport);
  void OnKey(CameraKey key);

  [[nodiscard]] bool dragging() const noexcept { return held_.has_value(); }

 private:
  Camera& camera_;
  std::optional<PointerButton> held_;
  Eigen::Vector2d at_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d pressed_at_ = Eigen::Vector2d::Zero();
  bool moved_ = false;  ///< The pointer has moved too far for a click since the button went down.
};

}  // namespace hgros::viewer
