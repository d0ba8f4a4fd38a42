#include <algorithm>
#include <cmath>
#include <string>

#include "viewer/app/viewer.hpp"

namespace hgros::viewer {

void Viewer::SetPaused(bool paused) {
  if (paused == paused_) return;
  paused_ = paused;
  if (paused) {
    scene_.CountDropped();
    KeepTransforms();
    return;
  }
  LookBack(0);
  const std::uint64_t lost = scene_.dropped();
  if (lost > 0) {
    notice_ =
        std::to_string(lost) + (lost == 1 ? " message was" : " messages were") + " dropped while the view stood still";
  }
}

// Of what stands still: the transforms themselves go on.
void Viewer::KeepTransforms() {
  kept_transforms_.clear();
  for (const Scene::Entry& entry : scene_.entries()) {
    const std::string frame = entry.display->data_frame();
    RigidTransform T_fixed_frame;
    std::string why;
    if (frame.empty() || frame_.Find(frame, T_fixed_frame, why) != FixedFrame::Answer::kFound) continue;
    kept_transforms_.insert_or_assign(frame, T_fixed_frame);
  }
}

std::optional<RigidTransform> Viewer::TransformInPicture(const std::string& frame) const {
  RigidTransform T_fixed_frame;
  std::string why;
  if (!paused_) {
    if (frame_.Find(frame, T_fixed_frame, why) != FixedFrame::Answer::kFound) return std::nullopt;
    return T_fixed_frame;
  }
  const auto kept = kept_transforms_.find(frame);
  if (back_s_ > 0 || kept == kept_transforms_.end()) return std::nullopt;
  return kept->second;
}

void Viewer::LookBack(double back_s) {
  back_s_ = std::clamp(back_s, 0.0, KeptS());
  scene_.LookBack(newest_s_, back_s_);
}

double Viewer::KeptS() const {
  const double oldest_s = std::max(scene_.oldest_s(), scene_.truthful_since_s());
  return std::isfinite(oldest_s) && std::isfinite(newest_s_) ? std::max(0.0, newest_s_ - oldest_s) : 0;
}

void Viewer::Step() {
  SetPaused(true);
  LookBack(0);
  steps_ = true;
}

}  // namespace hgros::viewer
