#include "viewer/data/frames/frame_ages.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace hgros::viewer {

void FrameAges::Update(std::span<const EdgeSnapshot> edges, double now_s) {
  std::map<std::string, Came, std::less<>> frames;
  for (const EdgeSnapshot& edge : edges) {
    if (edge.is_static) continue;
    const auto before = frames_.find(edge.child);
    const bool same = before != frames_.end() && before->second.sets == edge.sets;
    frames.insert_or_assign(edge.child, same ? before->second : Came{edge.sets, now_s});
  }
  frames_ = std::move(frames);
}

std::optional<double> FrameAges::AgeOf(std::string_view frame, double now_s) const {
  const auto found = frames_.find(frame);
  if (found == frames_.end()) return std::nullopt;
  return std::max(0.0, now_s - found->second.at_s);
}

bool FrameAges::HasAged(std::string_view frame, double age_s, double now_s) const {
  const auto found = frames_.find(frame);
  return found != frames_.end() && found->second.at_s + age_s <= now_s;
}

double FrameAges::NextAged(double age_s, double now_s) const {
  double next = std::numeric_limits<double>::infinity();
  for (const auto& [frame, came] : frames_) {
    if (came.at_s + age_s > now_s) next = std::min(next, came.at_s + age_s);
  }
  return next;
}

}  // namespace hgros::viewer
