#include "viewer/data/frames/pose_list.hpp"

#include <algorithm>

namespace hgros::viewer {
namespace {

bool IsFinite(const RigidTransform& pose) { return pose.translation.allFinite() && pose.rotation.coeffs().allFinite(); }

}  // namespace

PoseList::Pose PoseList::Drawn(const RigidTransform& pose) const {
  return {(pose.translation - origin_).cast<float>(), pose.rotation.coeffs().cast<float>()};
}

PoseList::Change PoseList::Replace(std::span<const RigidTransform> poses) {
  const bool was_empty = poses_.empty();
  const auto first = std::ranges::find_if(poses, IsFinite);
  left_out_ = 0;
  if (first == poses.end()) {
    left_out_ = poses.size();
    Clear();
    return was_empty ? Change::kNothing : Change::kRewritten;
  }
  // The origin stays while the poses that are there stay.
  if (was_empty) origin_ = first->translation;
  const std::size_t before = poses_.size();
  std::size_t kept = 0;
  bool same = true;
  for (const RigidTransform& pose : poses) {
    if (!IsFinite(pose)) {
      ++left_out_;
      continue;
    }
    const Pose drawn = Drawn(pose);
    if (kept == poses_.size()) {
      poses_.push_back(drawn);
    } else if (!(poses_[kept] == drawn)) {
      same = false;
      poses_[kept] = drawn;
    }
    ++kept;
  }
  if (kept < before) same = false;
  const bool grew = kept > before;
  poses_.resize(kept);
  if (was_empty) return Change::kAppended;
  if (!same) return Change::kRewritten;
  return grew ? Change::kAppended : Change::kNothing;
}

PoseList::Change PoseList::Append(const RigidTransform& pose) {
  if (!IsFinite(pose)) {
    ++left_out_;
    return Change::kNothing;
  }
  if (poses_.empty()) origin_ = pose.translation;
  poses_.push_back(Drawn(pose));
  return Change::kAppended;
}

PoseList::Change PoseList::KeepLast(std::size_t count) {
  if (poses_.size() <= count) return Change::kNothing;
  removed_ += poses_.size() - count;
  poses_.erase(poses_.begin(), poses_.end() - static_cast<std::ptrdiff_t>(count));
  return Change::kRewritten;
}

void PoseList::Clear() { poses_.clear(); }

}  // namespace hgros::viewer
