#include "viewer/data/frames/fixed_frame.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <vector>

namespace hgros::viewer {
namespace {

constexpr std::array<std::string_view, 4> kUsual = {"map", "world", "odom", "earth"};

/// The root with a usual name, or else the root with the most edges below it. Empty if there is no root.
std::string BestRoot(const std::vector<EdgeSnapshot>& edges) {
  std::map<std::string, std::string> parent;
  for (const EdgeSnapshot& edge : edges) parent[edge.child] = edge.parent;
  std::map<std::string, std::size_t> edges_below;
  for (const EdgeSnapshot& edge : edges) {
    std::string root = edge.parent;
    for (auto up = parent.find(root); up != parent.end(); up = parent.find(root)) root = up->second;
    ++edges_below[root];
  }
  for (const std::string_view usual : kUsual) {
    if (edges_below.contains(std::string(usual))) return std::string(usual);
  }
  const auto best = std::ranges::max_element(edges_below, {}, [](const auto& root) { return root.second; });
  return best == edges_below.end() ? std::string() : best->first;
}

}  // namespace

void FixedFrame::Ask(std::string_view name) {
  asked_ = !name.empty();
  name_ = name;
}

bool FixedFrame::Refresh() {
  if (asked_) return false;
  const std::vector<EdgeSnapshot> edges = tree_.Edges();
  if (edges.empty()) return false;
  std::string root = name_;
  const bool known =
      std::ranges::any_of(edges, [&](const EdgeSnapshot& edge) { return edge.parent == root || edge.child == root; });
  if (known) {  // The fixed frame stays in its tree. If that gets another root, the root becomes the fixed frame.
    for (bool up = true; up;) {
      up = false;
      for (const EdgeSnapshot& edge : edges) {
        if (edge.child == root) {
          root = edge.parent;
          up = true;
        }
      }
    }
  } else {
    root = BestRoot(edges);
  }
  if (root == name_) return false;
  name_ = root;
  return true;
}

bool FixedFrame::Saw(std::string_view frame) {
  if (!name_.empty() || frame.empty()) return false;
  name_ = frame;
  return true;
}

FixedFrame::Answer FixedFrame::Find(std::string_view frame, Time stamp, RigidTransform& T_fixed_frame,
                                    std::string& why) const {
  if (frame.empty() || frame == name_) {
    T_fixed_frame = RigidTransform();
    return Answer::kFound;
  }
  if (stamp == Time{}) return Find(frame, T_fixed_frame, why);
  const TransformResult found = tree_.Lookup(name_, frame, stamp);
  if (found) {
    T_fixed_frame = found->T_target_source;
    return Answer::kFound;
  }
  why = found.text();
  return found.fault() == TransformFault::kTooOld ? Answer::kNever : Answer::kLater;
}

FixedFrame::Answer FixedFrame::Find(std::string_view frame, RigidTransform& T_fixed_frame, std::string& why) const {
  if (frame.empty() || frame == name_) {
    T_fixed_frame = RigidTransform();
    return Answer::kFound;
  }
  const TransformResult found = tree_.Lookup(name_, frame);
  if (found) {
    T_fixed_frame = found->T_target_source;
    return Answer::kFound;
  }
  why = found.text();
  return Answer::kLater;
}

}  // namespace hgros::viewer
