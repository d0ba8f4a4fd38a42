#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include <foxglove/FrameTransforms.pb.h>

#include "hgros/base/fork_guard.hpp"
#include "hgros/clock/timer_queue.hpp"
#include "hgros/session/session.hpp"
#include "hgros/tf/transforms.hpp"
#include "tf/transform_sender.hpp"
#include "tf/tree/edge_owners.hpp"

namespace hgros {

// Connects a tree with the channels of a session. Thread safety: all functions except construction and destruction.
class Transforms::Core {
 public:
  const ForkGuard fork;  // A child has none of the threads.
  Core(Session& session, TransformsOptions options);
  // Also inside a callback of the session: those that run on other threads use this object.
  ~Core();
  Core(const Core&) = delete;
  Core& operator=(const Core&) = delete;

  TransformTree& tree() noexcept { return tree_; }
  tf::TransformSender& sender() noexcept { return sender_; }

  void Listen();
  SetResult SetMoving(std::span<const StampedEdge> edges);
  // `setter`: null if no component sets them.
  SetResult SetStatic(std::span<const StampedEdge> edges, const std::shared_ptr<tf::EdgeSetter>& setter);
  bool Withhold(tf::EdgeSetter& setter);
  void Release(const std::shared_ptr<tf::EdgeSetter>& setter);
  [[nodiscard]] TransformsStats stats() const;

 private:
  using Moment = tf::EdgeOwners::Moment;

  void Receive(const foxglove::FrameTransforms& message, const MessageInfo& info, bool is_static);
  SetResult Store(const foxglove::FrameTransform& transform, SessionId by, std::string_view publisher, bool is_static,
                  Time now);
  // As Check(). An edge with stamps of a clock that was set back begins again.
  SetResult SetChecked(std::string_view parent, std::string_view child, Time stamp,
                       const RigidTransform& T_parent_child, SessionId by, std::string_view publisher, Time now);
  // The latest stamp that the session can give, as far as its clock is known.
  [[nodiscard]] Time LatestOf(SessionId by, Time now) const;
  // Refuses a stamp that is too far ahead of `now`, even if the clock of `by` is known to be ahead.
  [[nodiscard]] SetResult Check(std::string_view parent, std::string_view child, Time stamp, Time now,
                                SessionId by) const;
  // The session's id while its name is unknown.
  std::string NameOf(SessionId session);
  // Empty if it is not there.
  [[nodiscard]] std::optional<std::string> NameOfPeer(SessionId session) const;
  void NoteMovingOwner(std::string_view parent, std::string_view child, SessionId by, Moment when);
  // Returns the child.
  std::optional<FrameId> NoteStaticOwner(std::string_view parent, std::string_view child, SessionId by);
  void ForgetGone();
  void SettleLater();
  void TellSharedStatics();
  void TellShared(const tf::EdgeOwners::Shared& edge);
  [[nodiscard]] bool IsThere(SessionId session) const { return session == session_.id() || NameOfPeer(session); }

  Session& session_;
  const std::shared_ptr<const void> reserved_;  // The session's only Transforms.
  const TransformsOptions options_;
  const Duration max_ahead_;
  const Duration shared_patience_;  // With two sessions that set a static edge.
  TransformTree tree_;
  tf::EdgeOwners owners_;
  std::atomic<std::uint64_t> received_{0};
  std::atomic<std::uint64_t> refused_{0};
  std::atomic<std::uint64_t> shared_{0};
  std::atomic<bool> said_full_{false};
  std::atomic<bool> said_jump_{false};
  std::mutex names_mutex_;
  std::unordered_map<SessionId, std::string> names_;
  tf::TransformSender sender_;
  std::once_flag listens_;
  std::mutex settles_mutex_;
  bool settles_ = false;                     // A timer is set.
  bool ends_ = false;                        // None is set any more.
  std::optional<TimerQueue> settle_timers_;  // Made when two sessions have set a static edge.
  Timer settle_timer_;
  Listening jumps_;                          // Destroyed before the tree, which it calls.
  std::vector<Subscription> subscriptions_;  // Last, because its callbacks use all other members.
};

}  // namespace hgros
