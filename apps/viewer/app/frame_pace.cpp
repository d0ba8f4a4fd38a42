#include "viewer/app/frame_pace.hpp"

namespace hgros::viewer {
namespace {

constexpr double kCountedS = 1;  // The status line shows the pictures of this time.

}  // namespace

void FramePace::BeginFrame(double now_s) {
  std::erase_if(recent_s_, [&](double time_s) { return time_s <= now_s - kCountedS; });
  idle_s_ = recent_s_.empty() ? kNever : now_s + kCountedS;
}

void FramePace::EndFrame(double now_s) {
  ++frames_;
  recent_s_.push_back(now_s);
}

}  // namespace hgros::viewer
