#include "hgros/tf/transforms.hpp"

#include <atomic>
#include <cmath>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/base/fork_guard.hpp"
#include "hgros/session/session_parts.hpp"
#include "tf/transform_messages.hpp"
#include "tf/transform_sender.hpp"
#include "tf/tree/edge_owners.hpp"

namespace hgros {
namespace {

std::string Edge(std::string_view parent, std::string_view child) {
  return "from \"" + std::string(parent.substr(0, 200)) + "\" to \"" + std::string(child.substr(0, 200)) + "\"";
}

constexpr Duration kLeastJump = std::chrono::seconds(1);
constexpr Duration kMaxAhead = std::chrono::seconds(10);
constexpr Duration kMaxAheadOfSimulation = std::chrono::hours(1);

std::shared_ptr<const void> Reserve(Session& session) {
  if (auto reserved = SessionParts(session).TryReserve("transforms")) return reserved;
  throw Error("The session \"" + session.name() + "\" has a Transforms already.", {},
              "Pass that one on by reference: with two, other sessions would get the static edges of only one. The "
              "default session's is hgros::DefaultTransforms().");
}

}  // namespace

// Connects a tree with the channels of a session. Thread safety: all functions except construction and destruction.
class Transforms::Core {
 public:
  const ForkGuard fork;  // A child has none of the threads.
  Core(Session& session, TransformsOptions options)
      : session_(session),
        reserved_(Reserve(session)),
        options_(std::move(options)),
        max_ahead_(options_.max_ahead.value_or(session.config().simulated_time ? kMaxAheadOfSimulation : kMaxAhead)),
        tree_(options_.tree),
        sender_(session, options_.batch) {
    jumps_ = session_.clock()->OnJump([this](const ClockJump& jump) {
      // If a wall clock is corrected by less than this, nothing is removed: later transforms are sorted among the
      // others.
      if (jump.before - jump.after < kLeastJump) return;
      // Stamps of transforms that are still in flight are near the time before the jump; stamps of later ones are
      // near the time after it.
      tree_.RestartTime(Later(jump.after, (jump.before - jump.after) / 2));
    });
  }

  // Also inside a callback of the session: those that run on other threads use this object.
  ~Core() {
    for (Subscription& one : subscriptions_) (void)one.Join();
  }
  Core(const Core&) = delete;
  Core& operator=(const Core&) = delete;

  TransformTree& tree() noexcept { return tree_; }
  tf::TransformSender& sender() noexcept { return sender_; }

  void Listen();
  SetResult Set(std::span<const StampedEdge> edges, bool is_static);
  [[nodiscard]] TransformsStats stats() const;

 private:
  void Receive(const foxglove::FrameTransforms& message, const MessageInfo& info, bool is_static);
  SetResult Store(const foxglove::FrameTransform& transform, SessionId by, std::string_view publisher, bool is_static,
                  Time now);
  // Refuses a stamp that is too far ahead of `now`, even if the clock of `by` is known to be ahead.
  [[nodiscard]] SetResult Check(std::string_view parent, std::string_view child, Time stamp, Time now,
                                SessionId by) const;
  // The session's id while its name is unknown.
  std::string NameOf(SessionId session);
  // Empty if it is not there.
  [[nodiscard]] std::optional<std::string> NameOfPeer(SessionId session) const;
  void NoteOwner(std::string_view parent, std::string_view child, SessionId by, bool is_static);

  Session& session_;
  const std::shared_ptr<const void> reserved_;  // The session's only Transforms.
  const TransformsOptions options_;
  const Duration max_ahead_;
  TransformTree tree_;
  tf::EdgeOwners owners_;
  std::atomic<std::uint64_t> received_{0};
  std::atomic<std::uint64_t> refused_{0};
  std::atomic<std::uint64_t> shared_{0};
  std::atomic<bool> said_full_{false};
  std::mutex names_mutex_;
  std::unordered_map<SessionId, std::string> names_;
  tf::TransformSender sender_;
  std::once_flag listens_;
  Listening jumps_;                          // Destroyed before the tree, which it calls.
  std::vector<Subscription> subscriptions_;  // Last, because its callbacks use all other members.
};

void Transforms::Core::Listen() {
  std::call_once(listens_, [this] {
    const auto listen = [this](std::string_view channel, NodeOptions node, bool is_static) {
      subscriptions_.push_back(session_.FromAny<foxglove::FrameTransforms>(
          channel, Invoke::kSerial,
          [this, is_static](const foxglove::FrameTransforms& message, const MessageInfo& info) {
            Receive(message, info, is_static);
          },
          std::move(node)));
    };
    NodeOptions still = options_.node;
    if (!still.name.empty()) still.name += "_static";
    listen(kStaticTransformsChannel, std::move(still), true);
    listen(kTransformsChannel, options_.node, false);
  });
}

SetResult Transforms::Core::Set(std::span<const StampedEdge> edges, bool is_static) {
  is_static ? sender_.OpenStatic() : sender_.OpenMoving();
  SetResult first_refusal;
  std::vector<const StampedEdge*> taken;
  taken.reserve(edges.size());
  const Time now = session_.clock()->Now();
  for (const StampedEdge& edge : edges) {
    SetResult result = is_static ? SetResult() : Check(edge.parent, edge.child, edge.stamp, now, session_.id());
    if (result) {
      result = is_static ? tree_.SetStatic(edge.parent, edge.child, edge.T_parent_child, session_.name())
                         : tree_.Set(edge.parent, edge.child, edge.stamp, edge.T_parent_child, session_.name());
    }
    if (result) {
      NoteOwner(edge.parent, edge.child, session_.id(), is_static);
      taken.push_back(&edge);
    } else if (first_refusal) {
      first_refusal = std::move(result);
    }
  }
  is_static ? sender_.SendStatic(taken) : sender_.SendMoving(taken);
  return first_refusal;
}

void Transforms::Core::Receive(const foxglove::FrameTransforms& message, const MessageInfo& info, bool is_static) {
  if (!info.remote && sender_.IsOwn(message)) return;
  const SessionId by{info.id.publisher};
  const std::string publisher = NameOf(by);
  received_ += static_cast<std::uint64_t>(message.transforms_size());
  bool taken = false;
  const Time now = session_.clock()->Now();
  for (const foxglove::FrameTransform& transform : message.transforms()) {
    const std::string& parent = transform.parent_frame_id();
    const std::string& child = transform.child_frame_id();
    if (const SetResult result = Store(transform, by, publisher, is_static, now)) {
      NoteOwner(parent, child, by, is_static);
      taken = true;
    } else if (++refused_; result.fault() == SetFault::kTooManyFrames) {
      if (!said_full_.exchange(true)) {
        session_.log().Write(LogLevel::kError, "A transform of session \"" + publisher + "\": " + result.text() +
                                                   " Further ones refused for this reason are only counted.");
      }
    } else {
      const std::string alike = "transform " + std::to_string(static_cast<int>(result.fault())) + " " + by.ToString();
      session_.log().WriteLimited(LogLevel::kWarning, alike,
                                  "A transform of session \"" + publisher + "\": " + result.text());
    }
  }
  if (taken && options_.on_received) options_.on_received();
}

SetResult Transforms::Core::Store(const foxglove::FrameTransform& transform, SessionId by, std::string_view publisher,
                                  bool is_static, Time now) {
  const std::string& parent = transform.parent_frame_id();
  const std::string& child = transform.child_frame_id();
  const RigidTransform T_parent_child = tf::TransformOf(transform);
  if (is_static) return tree_.SetStatic(parent, child, T_parent_child, publisher);
  if (const auto stamp = tf::StampOf(transform)) {
    if (SetResult result = Check(parent, child, *stamp, now, by); !result) return result;
    return tree_.Set(parent, child, *stamp, T_parent_child, publisher);
  }
  return {SetFault::kTooOld, "The edge " + Edge(parent, child) + " was refused: its timestamp is invalid."};
}

// A clock that stands at 0 is a simulated one that was not heard yet.
SetResult Transforms::Core::Check(std::string_view parent, std::string_view child, Time stamp, Time now,
                                  SessionId by) const {
  const Time limit = Later(now, max_ahead_);
  if (now == Time{} || stamp <= limit) return {};
  const auto clock = session_.OffsetTo(by);
  if (clock && clock->offset > Duration(0) && stamp <= Later(limit, clock->offset + clock->uncertainty)) return {};
  const auto seconds = [](double nanoseconds) { return std::to_string(std::llround(nanoseconds * 1e-9)) + " s"; };
  return {SetFault::kTooNew,
          "The transform " + Edge(parent, child) + " was refused: its stamp is " +
              seconds(static_cast<double>(stamp.nanoseconds) - static_cast<double>(now.nanoseconds)) +
              " ahead of the clock of session \"" + session_.name() + "\", more than TransformsOptions::max_ahead (" +
              seconds(static_cast<double>(max_ahead_.count())) +
              "). Stamp with session.clock()->Now(), and synchronize the clocks of the hosts."};
}

std::string Transforms::Core::NameOf(SessionId session) {
  if (session == session_.id()) return session_.name();
  const std::scoped_lock lock(names_mutex_);
  if (const auto place = names_.find(session); place != names_.end()) return place->second;
  if (const auto name = NameOfPeer(session)) return names_.emplace(session, *name).first->second;
  return session.ToString();
}

std::optional<std::string> Transforms::Core::NameOfPeer(SessionId session) const {
  for (const PeerInfo& peer : session_.Peers()) {
    if (peer.id == session) return peer.process;
  }
  return std::nullopt;
}

void Transforms::Core::NoteOwner(std::string_view parent, std::string_view child, SessionId by, bool is_static) {
  const auto frame = tree_.Find(child);
  if (!frame) return;
  const auto other = owners_.Note(*frame, by, is_static);
  if (!other || (*other != session_.id() && !NameOfPeer(*other)) || !owners_.Settle(*frame)) return;
  ++shared_;
  session_.log().WriteLimited(LogLevel::kWarning, "shared edge",
                              "Two sessions set the edge " + Edge(parent, child) + ": \"" + NameOf(*other) + "\" (" +
                                  other->ToString() + ") and \"" + NameOf(by) + "\" (" + by.ToString() +
                                  "). Lookups return either of the two; let only one session set it.");
}

TransformsStats Transforms::Core::stats() const {
  return {.sent_messages = sender_.sent_messages(),
          .sent_transforms = sender_.sent_transforms(),
          .unsent_transforms = sender_.unsent_transforms(),
          .received_transforms = received_,
          .refused_transforms = refused_,
          .shared_edges = shared_};
}

Transforms::Transforms(Session& session, const TransformsOptions& options)
    : core_(std::make_unique<Core>(session, options)) {}
Transforms::~Transforms() {
  if (core_->fork.IsChild()) LeaveToParent(std::shared_ptr<const Core>(std::move(core_)));
}

SetResult Transforms::ToTF(Time stamp, std::string_view parent, std::string_view child,
                           const RigidTransform& T_parent_child) {
  const StampedEdge edge{std::string(parent), std::string(child), stamp, T_parent_child};
  return core_->Set({&edge, 1}, false);
}

SetResult Transforms::ToTF(std::span<const StampedEdge> edges) { return core_->Set(edges, false); }

SetResult Transforms::ToStaticTF(std::string_view parent, std::string_view child,
                                 const RigidTransform& T_parent_child) {
  const StampedEdge edge{std::string(parent), std::string(child), {}, T_parent_child};
  return core_->Set({&edge, 1}, true);
}

SetResult Transforms::ToStaticTF(std::span<const StampedEdge> edges) { return core_->Set(edges, true); }

TransformTree& Transforms::tree() {
  core_->Listen();
  return core_->tree();
}

void Transforms::Flush() { core_->sender().Flush(); }

TransformsStats Transforms::stats() const { return core_->stats(); }

}  // namespace hgros
