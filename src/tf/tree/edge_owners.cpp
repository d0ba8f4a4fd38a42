#include "tf/tree/edge_owners.hpp"

#include <algorithm>
#include <utility>

namespace hgros::tf {

std::optional<SessionId> EdgeOwners::NoteMoving(FrameId child, SessionId by, Moment now) {
  const std::scoped_lock lock(mutex_);
  Owner& owner = owners_[child.value];
  if (owner.last == by || owner.said) {
    ++owner.sets;
    return std::nullopt;
  }
  if (by != owner.before || now - owner.changed > kLongestTurn) owner.returns = 0;
  if (by == owner.before && owner.sets <= kFewSets && now - owner.changed <= kLongestTurn) ++owner.returns;
  owner.changed = now;
  owner.sets = 1;
  Follow(owner, by);
  return owner.returns >= kReturnsOfShared ? std::optional(owner.before) : std::nullopt;
}

bool EdgeOwners::NoteStatic(FrameId parent, FrameId child, SessionId by, Moment due) {
  const std::scoped_lock lock(mutex_);
  Owner& owner = owners_[child.value];
  statics_[by].insert(child.value);
  if (owner.last == by || owner.said) return false;
  Follow(owner, by);
  if (owner.before == kNobody) return false;
  suspects_.try_emplace(child.value, Suspect{parent, due});
  return true;
}

void EdgeOwners::Keep(SessionId by, std::span<const FrameId> children) {
  const std::scoped_lock lock(mutex_);
  const auto place = statics_.find(by);
  if (place == statics_.end()) return;
  std::unordered_set<std::uint32_t> kept;
  for (const FrameId child : children) kept.insert(child.value);
  std::erase_if(place->second, [&](std::uint32_t child) {
    if (kept.contains(child)) return false;
    Forget(child, by);
    return true;
  });
  if (place->second.empty()) statics_.erase(place);
}

void EdgeOwners::Withdraw(SessionId by, FrameId child) {
  const std::scoped_lock lock(mutex_);
  const auto place = statics_.find(by);
  if (place != statics_.end() && place->second.erase(child.value) != 0) Forget(child.value, by);
}

bool EdgeOwners::is_crowded() const {
  const std::scoped_lock lock(mutex_);
  return statics_.size() >= crowd_;
}

void EdgeOwners::KeepSessions(const std::unordered_set<SessionId>& there) {
  const std::scoped_lock lock(mutex_);
  std::erase_if(statics_, [&](const auto& one) { return !there.contains(one.first); });
  crowd_ = std::max(kLeastCrowd, 2 * statics_.size());
}

std::vector<EdgeOwners::Shared> EdgeOwners::TakeShared(Moment now) {
  const std::scoped_lock lock(mutex_);
  std::vector<Shared> shared;
  std::erase_if(suspects_, [&](const auto& one) {
    const auto& [child, suspect] = one;
    if (suspect.due > now) return false;
    const Owner& owner = owners_[child];
    shared.push_back({suspect.parent, FrameId{child}, owner.before, owner.last});
    return true;
  });
  return shared;
}

bool EdgeOwners::has_suspects() const {
  const std::scoped_lock lock(mutex_);
  return !suspects_.empty();
}

bool EdgeOwners::Settle(FrameId child) {
  const std::scoped_lock lock(mutex_);
  const auto place = owners_.find(child.value);
  if (place == owners_.end() || place->second.said) return false;
  return place->second.said = true;
}

void EdgeOwners::Follow(Owner& owner, SessionId by) noexcept {
  if (owner.last != kNobody) owner.before = owner.last;
  owner.last = by;
}

void EdgeOwners::Forget(std::uint32_t child, SessionId by) {
  Owner& owner = owners_[child];
  if (owner.before == by) owner.before = kNobody;
  if (owner.last == by) owner.last = std::exchange(owner.before, kNobody);
  if (owner.before == kNobody) suspects_.erase(child);
}

}  // namespace hgros::tf
