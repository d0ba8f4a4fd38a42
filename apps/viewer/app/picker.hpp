#pragma once

#include <Eigen/Core>
#include <string>

#include "viewer/app/playback.hpp"
#include "viewer/app/surface/surface.hpp"
#include "viewer/scene/scene.hpp"
#include "viewer/view/camera.hpp"
#include "viewer/view/point_picks.hpp"

namespace hgros::viewer {

/// Handles clicks in the scene: a click sets the camera's anchor, or picks a point to be measured.
class Picker {
 public:
  Picker(Scene& scene, Camera& camera, const FixedFrame& frame, const Playback& playback)
      : scene_(scene), camera_(camera), frame_(frame), playback_(playback) {}

  /// Whether clicks pick points without the shift key, too.
  [[nodiscard]] bool active() const noexcept { return active_; }
  void ToggleActive() { active_ = !active_; }
  /// Forgets the points and is not active any more.
  void Clear();
  [[nodiscard]] PointPicks& picks() noexcept { return picks_; }

  /// Sets the anchor, or picks a point. Returns the notice for the status line.
  [[nodiscard]] std::string Click(const Surface& surface, const Eigen::Vector2d& pixel, bool picks);

 private:
  Scene& scene_;
  Camera& camera_;
  const FixedFrame& frame_;
  const Playback& playback_;
  bool active_ = false;
  PointPicks picks_;
};

}  // namespace hgros::viewer
