#include "viewer/scene/blending_order.hpp"

#include <algorithm>

namespace hgros::viewer {
namespace {

double Reach(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& eye) {
  if (box.isEmpty()) return 0;
  return (box.min() - eye).cwiseAbs().cwiseMax((box.max() - eye).cwiseAbs()).norm();
}

/// Whether `a` must be drawn before `b`.
bool IsBehind(const Eigen::AlignedBox3d& a, const Eigen::AlignedBox3d& b, const Eigen::Vector3d& eye) {
  if (a.isEmpty() || b.isEmpty()) return !a.isEmpty();
  for (int axis = 0; axis < 3; ++axis) {
    // If a plane separates them, the box on the eye's side is in front. If the eye is between them, it does not see
    // both at once.
    if (b.max()[axis] <= a.min()[axis]) return eye[axis] <= b.max()[axis];
    if (a.max()[axis] <= b.min()[axis]) return eye[axis] >= b.min()[axis];
  }
  return Reach(a, eye) > Reach(b, eye);
}

}  // namespace

std::vector<std::size_t> BlendingOrder(std::span<const Eigen::AlignedBox3d> boxes, const Eigen::Vector3d& eye) {
  std::vector<std::size_t> waiting(boxes.size());
  for (std::size_t i = 0; i < waiting.size(); ++i) waiting[i] = i;
  std::vector<std::size_t> order;
  while (!waiting.empty()) {
    // Boxes may form a ring, each behind the next. Then the first one is drawn.
    const auto is_last = [&](std::size_t one) {
      return std::ranges::none_of(waiting, [&](std::size_t other) { return IsBehind(boxes[other], boxes[one], eye); });
    };
    const auto next = std::ranges::find_if(waiting, is_last);
    const auto taken = next == waiting.end() ? waiting.begin() : next;
    order.push_back(*taken);
    waiting.erase(taken);
  }
  return order;
}

}  // namespace hgros::viewer
