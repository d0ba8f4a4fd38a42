#include "viewer/scene/displays/placement.hpp"

#include <utility>

namespace hgros::viewer {

bool Placement::Follow(const std::string& frame, const UpdateContext& context) {
  if (frame != frame_ || context.frame_changed) known_ = false;
  frame_ = frame;
  wait_.Pass(context.now_s);
  if (known_ && !context.transforms_changed) return false;
  context.frame.Saw(frame);
  RigidTransform now;
  std::string why;
  if (context.frame.Find(frame, now, why) != FixedFrame::Answer::kFound) {
    wait_.Miss(std::move(why), context.now_s);
    return false;
  }
  wait_ = {};
  const bool same =
      known_ && now.translation == placed_.translation && now.rotation.coeffs() == placed_.rotation.coeffs();
  placed_ = now;
  known_ = true;
  return !same;
}

}  // namespace hgros::viewer
