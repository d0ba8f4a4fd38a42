#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <vector>

#include "hgros/tf/rigid_transform.hpp"
#include "hgros/tf/transform_result.hpp"

namespace hgros::test {

/// The expected results of a transform tree, computed in the simplest way: maps of stamps, Eigen's slerp, products
/// from the root.
class NaiveTree {
 public:
  struct Found {
    TransformFault fault = TransformFault::kNone;
    RigidTransform T_target_source;
    std::int64_t stamp = 0;
  };

  NaiveTree(std::size_t frames, std::int64_t buffer, std::size_t count)
      : parents_(frames), edges_(frames), buffer_(buffer), count_(count) {}

  void SetStatic(std::size_t parent, std::size_t child, const RigidTransform& T) {
    parents_[child] = parent;
    edges_[child].is_static = true;
    edges_[child].samples = {{0, T}};
  }
  /// False if it is too old.
  bool Set(std::size_t parent, std::size_t child, std::int64_t stamp, const RigidTransform& T) {
    parents_[child] = parent;
    auto& samples = edges_[child].samples;
    if (!samples.empty() && stamp < samples.rbegin()->first - buffer_) return false;
    const bool is_new = samples.find(stamp) == samples.end();
    if (is_new && samples.size() == count_ && stamp < samples.begin()->first) return false;
    samples[stamp] = T;
    while (samples.size() > count_ || samples.begin()->first < samples.rbegin()->first - buffer_) {
      samples.erase(samples.begin());
    }
    return true;
  }

  [[nodiscard]] Found Lookup(std::size_t target, std::size_t source, std::optional<std::int64_t> stamp) const {
    std::vector<std::size_t> from_target = Up(target);
    std::vector<std::size_t> from_source = Up(source);
    const auto root = [](const std::vector<std::size_t>& up) { return up.back(); };
    if (from_target.size() == 1 && !HasChild(target)) return {TransformFault::kUnknownFrame, {}, 0};
    if (from_source.size() == 1 && !HasChild(source)) return {TransformFault::kUnknownFrame, {}, 0};
    if (root(from_target) != root(from_source)) return {TransformFault::kNotConnected, {}, 0};
    while (from_target.size() > 1 && from_source.size() > 1 &&
           from_target[from_target.size() - 2] == from_source[from_source.size() - 2]) {
      from_target.pop_back();
      from_source.pop_back();
    }
    Found found;
    constexpr auto kMost = std::numeric_limits<std::int64_t>::max();
    found.stamp = stamp.value_or(kMost);
    if (!stamp) {
      for (const auto& up : {from_target, from_source}) {
        for (std::size_t i = 0; i + 1 < up.size(); ++i) {
          const Edge& edge = edges_[up[i]];
          if (!edge.is_static) found.stamp = std::min(found.stamp, edge.samples.rbegin()->first);
        }
      }
      if (found.stamp == kMost) found.stamp = 0;
    }
    const RigidTransform target_pose = Compose(from_target, found);
    const RigidTransform source_pose = Compose(from_source, found);
    found.T_target_source = target_pose.Inverse() * source_pose;
    return found;
  }

 private:
  struct Edge {
    bool is_static = false;
    std::map<std::int64_t, RigidTransform> samples;
  };

  [[nodiscard]] std::vector<std::size_t> Up(std::size_t frame) const {
    std::vector<std::size_t> up{frame};
    while (parents_[up.back()]) up.push_back(*parents_[up.back()]);
    return up;
  }
  [[nodiscard]] bool HasChild(std::size_t frame) const {
    return std::find(parents_.begin(), parents_.end(), std::optional(frame)) != parents_.end();
  }
  [[nodiscard]] RigidTransform Compose(const std::vector<std::size_t>& up, Found& found) const {
    RigidTransform sum;
    for (std::size_t i = 0; i + 1 < up.size(); ++i) sum = At(edges_[up[i]], found) * sum;
    return sum;
  }
  [[nodiscard]] static RigidTransform At(const Edge& edge, Found& found) {
    if (edge.is_static) return edge.samples.begin()->second;
    const auto after = edge.samples.lower_bound(found.stamp);
    if (after == edge.samples.end()) {
      found.fault = TransformFault::kTooNew;
      return {};
    }
    if (after->first == found.stamp) return after->second;
    if (after == edge.samples.begin()) {
      found.fault = TransformFault::kTooOld;
      return {};
    }
    const auto before = std::prev(after);
    const double t =
        static_cast<double>(found.stamp - before->first) / static_cast<double>(after->first - before->first);
    const RigidTransform& a = before->second;
    const RigidTransform& b = after->second;
    return {a.rotation.slerp(t, b.rotation), a.translation + t * (b.translation - a.translation)};
  }

  std::vector<std::optional<std::size_t>> parents_;
  std::vector<Edge> edges_;
  std::int64_t buffer_;
  std::size_t count_;
};

}  // namespace hgros::test
