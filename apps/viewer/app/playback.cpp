#include "viewer/app/playback.hpp"

#include <algorithm>
#include <cmath>

namespace hgros::viewer {

void Playback::Pause() {
  if (std::exchange(paused_, true)) return;
  scene_.CountDropped();
  KeepTransforms();
}

std::uint64_t Playback::Resume() {
  if (!std::exchange(paused_, false)) return 0;
  LookBack(0);
  return scene_.dropped();
}

void Playback::Step() {
  Pause();
  LookBack(0);
  steps_ = true;
}

bool Playback::BeginTurn(double now_s) {
  if (paused_ && !std::exchange(steps_, false)) return false;
  newest_s_ = now_s;
  return true;
}

void Playback::EndTurn() {
  if (paused_) KeepTransforms();
}

void Playback::LookBack(double back_s) {
  back_s_ = std::clamp(back_s, 0.0, longest_back_s());
  scene_.LookBack(newest_s_, back_s_);
}

double Playback::longest_back_s() const {
  const double oldest_s = std::max(scene_.oldest_s(), scene_.truthful_since_s());
  return std::isfinite(oldest_s) && std::isfinite(newest_s_) ? std::max(0.0, newest_s_ - oldest_s) : 0;
}

void Playback::KeepTransforms() {
  kept_transforms_.clear();
  for (const Scene::Entry& entry : scene_.entries()) {
    const std::string frame = entry.display->data_frame();
    RigidTransform T_fixed_frame;
    std::string why;
    if (frame.empty() || frame_.Find(frame, T_fixed_frame, why) != FixedFrame::Answer::kFound) continue;
    kept_transforms_.insert_or_assign(frame, T_fixed_frame);
  }
}

std::optional<RigidTransform> Playback::TransformInPicture(const std::string& frame) const {
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

}  // namespace hgros::viewer
