#pragma once

#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "hgros/tf/transform_tree.hpp"
#include "viewer/data/frames/fixed_frame.hpp"
#include "viewer/scene/scene.hpp"

namespace hgros::viewer {

/// Pausing the picture, stepping, and looking back.
///
/// While the picture is paused, messages wait in the displays' inboxes, which drop the oldest ones.
class Playback {
 public:
  Playback(Scene& scene, const FixedFrame& frame) : scene_(scene), frame_(frame) {}

  void Pause();
  /// Continues. Returns the number of messages that were dropped during the pause.
  std::uint64_t Resume();
  /// Pauses, and shows once what has arrived until now.
  void Step();
  /// Whether new messages are to be shown in this turn. Forgets the step.
  [[nodiscard]] bool BeginTurn(double now_s);
  /// Call it when a turn has taken in messages.
  void EndTurn();

  void LookBack(double back_s);
  [[nodiscard]] bool paused() const noexcept { return paused_; }
  [[nodiscard]] double back_s() const noexcept { return back_s_; }
  /// How far back the picture can go while it shows everything that was there.
  [[nodiscard]] double longest_back_s() const;
  /// T_fixed_frame as the picture shows it; none if that is not known any more.
  [[nodiscard]] std::optional<RigidTransform> TransformInPicture(const std::string& frame) const;

 private:
  static constexpr double kNever = std::numeric_limits<double>::infinity();

  /// The tree of transforms does not pause: this keeps those that the picture was drawn with.
  void KeepTransforms();

  Scene& scene_;
  const FixedFrame& frame_;
  bool paused_ = false;
  bool steps_ = false;
  double newest_s_ = -kNever;  ///< When displays took in something last.
  double back_s_ = 0;
  std::map<std::string, RigidTransform> kept_transforms_;  ///< For the displays' frames, during a pause.
};

}  // namespace hgros::viewer
