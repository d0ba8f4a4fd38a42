#include "viewer/app/picker.hpp"

#include <utility>

namespace hgros::viewer {
namespace {

constexpr int kPickRadius = 6;  // Pixels around a click in which the nearest point is taken.

}  // namespace

void Picker::Clear() {
  active_ = false;
  picks_.Clear();
}

std::string Picker::Click(const Surface& surface, const Eigen::Vector2d& pixel, bool picks) {
  int x = static_cast<int>(pixel.x());
  int y = static_cast<int>(pixel.y());
  const int radius = static_cast<int>(kPickRadius * surface.scale());
  const Viewport size = surface.size();
  const ViewMatrices view = camera_.Matrices(size);
  float depth = scene_.NearestDepth(view, surface.scale(), x, y, radius);
  if (depth >= 1) return picks ? "There is nothing to pick." : "There is nothing to set the anchor on.";
  const auto seen = [&](int right) {
    return camera_.PointAt(x + right + 0.5, y + 0.5, static_cast<double>(depth), size);
  };
  if (!picks) {
    scene_.CorrectDepth(view, surface.scale(), x, y, depth);
    camera_.SetAnchor(seen(0));
    return "anchor at " + MetersText(seen(0));
  }
  const Scene::Entry* const entry = scene_.EntryAt(view, surface.scale(), x, y, depth);
  const Eigen::Vector3d at = seen(0);
  PickedPoint point;
  point.at = at;
  if (entry != nullptr) {
    point.display = entry->name;
    point.value = entry->display->ValueAt(at, (seen(radius) - at).norm());
    const std::string frame = entry->display->data_frame();
    const bool other = !frame.empty() && frame != frame_.name();
    if (const auto T_fixed_frame = other ? playback_.TransformInPicture(frame) : std::nullopt) {
      point.frame = frame;
      point.in_frame = T_fixed_frame->Inverse() * at;
    }
  }
  std::string notice = "picked " + MetersText(at) + (point.display.empty() ? "" : " of " + point.display);
  picks_.Add(std::move(point));
  return notice;
}

}  // namespace hgros::viewer
