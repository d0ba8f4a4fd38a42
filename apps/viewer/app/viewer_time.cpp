#include <algorithm>
#include <cmath>
#include <string>

#include "viewer/app/viewer.hpp"

namespace hgros::viewer {

void Viewer::SetPaused(bool paused) {
  if (paused == paused_) return;
  paused_ = paused;
  if (paused) {
    dropped_before_ = scene_.dropped();
    return;
  }
  LookBack(0);
  const std::uint64_t lost = scene_.dropped() - dropped_before_;
  if (lost > 0) notice_ = std::to_string(lost) + " messages were dropped while the view stood still";
}

void Viewer::LookBack(double back_s) {
  back_s_ = std::clamp(back_s, 0.0, KeptS());
  scene_.LookBack(newest_s_, back_s_);
}

double Viewer::KeptS() const {
  const double oldest_s = scene_.oldest_s();
  return std::isfinite(oldest_s) && std::isfinite(newest_s_) ? std::max(0.0, newest_s_ - oldest_s) : 0;
}

void Viewer::Step() {
  SetPaused(true);
  LookBack(0);
  steps_ = true;
}

}  // namespace hgros::viewer
