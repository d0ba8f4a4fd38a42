#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <unordered_map>

#include "hgros/base/ids.hpp"
#include "hgros/tf/transform_query.hpp"

namespace hgros::tf {

/// Detects edges that two sessions set. Thread-safe.
class EdgeOwners {
 public:
  /// `by` has set the edge above `child`. Returns the session that set it before if both probably continue to set it.
  /// This is the case if a moving edge returns to an earlier session, or if another session sets a static edge. A
  /// session that restarted under a new id does not count as a second one.
  [[nodiscard]] std::optional<SessionId> Note(FrameId child, SessionId by, bool is_static) {
    const std::scoped_lock lock(mutex_);
    const auto [place, is_new] = owners_.try_emplace(child.value, Owner{by, {}, false});
    Owner& owner = place->second;
    if (is_new || owner.last == by || owner.said) return std::nullopt;
    const bool back = owner.before == by;
    owner.before = owner.last;
    owner.last = by;
    return back || is_static ? std::optional(owner.before) : std::nullopt;
  }
  /// Reports nothing more about this edge. True for one caller only.
  [[nodiscard]] bool Settle(FrameId child) {
    const std::scoped_lock lock(mutex_);
    const auto place = owners_.find(child.value);
    if (place == owners_.end() || place->second.said) return false;
    return place->second.said = true;
  }

 private:
  struct Owner {
    SessionId last;
    SessionId before;
    bool said = false;
  };
  std::mutex mutex_;
  std::unordered_map<std::uint32_t, Owner> owners_;
};

}  // namespace hgros::tf
