#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "hgros/base/ids.hpp"
#include "hgros/tf/transform_query.hpp"

namespace hgros::tf {

/// Detects edges that two sessions set. Thread-safe.
class EdgeOwners {
 public:
  using Moment = std::chrono::steady_clock::time_point;
  struct Shared {
    FrameId parent;
    FrameId child;
    SessionId before;
    SessionId last;
  };

  /// `by` has set a moving edge. Returns the session that set it before if both probably continue to set it. This is
  /// the case if the edge returns to the session before the last one again and again, and the last one has set it only
  /// a few times meanwhile. One that restarted under a new id is not such a session, and a component that moves to
  /// another session and back sets it more often.
  [[nodiscard]] std::optional<SessionId> NoteMoving(FrameId child, SessionId by, Moment now);
  /// `by` has set a static edge. True if another session has set it as well and has not withdrawn it: TakeShared()
  /// returns it if that is still so after `due`.
  [[nodiscard]] bool NoteStatic(FrameId parent, FrameId child, SessionId by, Moment due);
  /// Static edges that `by` has set, except for `children`, have been withdrawn.
  void Keep(SessionId by, std::span<const FrameId> children);
  /// `by` has withdrawn a static edge.
  void Withdraw(SessionId by, FrameId child);
  /// Whether there may be many sessions that are gone: see KeepSessions().
  [[nodiscard]] bool is_crowded() const;
  /// The static edges of all other sessions are forgotten.
  void KeepSessions(const std::unordered_set<SessionId>& there);
  /// Static edges that two sessions still set after their time, each once.
  [[nodiscard]] std::vector<Shared> TakeShared(Moment now);
  [[nodiscard]] bool has_suspects() const;
  /// Reports nothing more about this edge. True for one caller only.
  [[nodiscard]] bool Settle(FrameId child);

 private:
  static constexpr SessionId kNobody{};
  static constexpr std::size_t kLeastCrowd = 64;
  static constexpr int kReturnsOfShared = 3;
  static constexpr std::uint64_t kFewSets = 3;
  static constexpr std::chrono::seconds kLongestTurn{5};  // Of two sessions that set a moving edge.
  struct Owner {
    SessionId last = kNobody;
    SessionId before = kNobody;
    bool said = false;
    // Of a moving edge:
    int returns = 0;         // To the session before the last, each soon after the one before.
    std::uint64_t sets = 0;  // By the last one in a row.
    Moment changed{};        // When the last one has set it first.
  };
  struct Suspect {
    FrameId parent;
    Moment due;
  };

  static void Follow(Owner& owner, SessionId by) noexcept;
  void Forget(std::uint32_t child, SessionId by);

  mutable std::mutex mutex_;
  std::unordered_map<std::uint32_t, Owner> owners_;  // By child, as the next.
  std::unordered_map<std::uint32_t, Suspect> suspects_;
  std::unordered_map<SessionId, std::unordered_set<std::uint32_t>> statics_;  // Children of edges.
  std::size_t crowd_ = kLeastCrowd;                                           // When to look who is gone.
};

}  // namespace hgros::tf
