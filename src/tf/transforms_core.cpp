#include "tf/transforms_core.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_set>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/clock/system_clocks.hpp"
#include "hgros/session/session_parts.hpp"
#include "tf/transform_messages.hpp"

namespace hgros {
namespace {

std::string Edge(std::string_view parent, std::string_view child) {
  return "from \"" + std::string(parent.substr(0, 200)) + "\" to \"" + std::string(child.substr(0, 200)) + "\"";
}

constexpr Duration kLeastJump = std::chrono::seconds(1);
constexpr Duration kMaxAhead = std::chrono::seconds(10);
constexpr Duration kMaxAheadOfSimulation = std::chrono::hours(1);
// A component that moves sets its static edges in the new place right after they are withdrawn in the old one, and the
// two messages come over different links. And that a process on another host has died is known only once it was silent
// for long enough.
Duration SharedPatience(const Config& config) {
  return std::max<Duration>(std::chrono::seconds(2),
                            std::chrono::milliseconds(config.peer_timeout_ms + 2 * config.heartbeat_ms));
}

// Those of `edges` that `set` takes, and its first refusal.
template <typename Set>
std::pair<std::vector<const StampedEdge*>, SetResult> Take(std::span<const StampedEdge> edges, const Set& set) {
  std::pair<std::vector<const StampedEdge*>, SetResult> all;
  auto& [taken, refusal] = all;
  taken.reserve(edges.size());
  for (const StampedEdge& edge : edges) {
    SetResult result = set(edge);
    if (result) {
      taken.push_back(&edge);
    } else if (refusal) {
      refusal = std::move(result);
    }
  }
  return all;
}

std::shared_ptr<const void> Reserve(Session& session) {
  if (auto reserved = SessionParts(session).TryReserve("transforms")) return reserved;
  throw Error("The session \"" + session.name() + "\" has a Transforms already.", {},
              "Pass that one on by reference: with two, other sessions would get the static edges of only one. The "
              "default session's is hgros::DefaultTransforms().");
}

}  // namespace

Transforms::Core::Core(Session& session, TransformsOptions options)
    : session_(session),
      reserved_(Reserve(session)),
      options_(std::move(options)),
      max_ahead_(options_.max_ahead.value_or(session.config().simulated_time ? kMaxAheadOfSimulation : kMaxAhead)),
      shared_patience_(SharedPatience(session.config())),
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

Transforms::Core::~Core() {
  for (Subscription& one : subscriptions_) (void)one.Join();
  Timer last;  // Ends after the lock, as in SettleLater().
  const std::scoped_lock lock(settles_mutex_);
  ends_ = true;
  last = std::exchange(settle_timer_, {});
}

void Transforms::Core::Listen() {
  std::call_once(listens_, [this] {
    std::vector<Subscription> both;  // Or none, if it throws.
    const auto listen = [&](std::string_view channel, NodeOptions node, bool is_static) {
      both.push_back(session_.FromAny<foxglove::FrameTransforms>(
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
    subscriptions_ = std::move(both);
  });
}

SetResult Transforms::Core::SetMoving(std::span<const StampedEdge> edges) {
  sender_.OpenMoving();
  const Moment when = Moment::clock::now();
  const Time now = session_.clock()->Now();
  const auto set = [&](const StampedEdge& edge) {
    SetResult result =
        SetChecked(edge.parent, edge.child, edge.stamp, edge.T_parent_child, session_.id(), session_.name(), now);
    if (result) NoteMovingOwner(edge.parent, edge.child, session_.id(), when);
    return result;
  };
  auto [taken, refusal] = Take(edges, set);
  sender_.SendMoving(taken);
  return refusal;
}

// An edge that is withheld replaces none in the tree: the component may not begin in this place.
SetResult Transforms::Core::SetStatic(std::span<const StampedEdge> edges,
                                      const std::shared_ptr<tf::EdgeSetter>& setter) {
  sender_.OpenStatic();
  const bool withheld = setter && sender_.Withholds(*setter);
  const auto set = [&](const StampedEdge& edge) {
    SetResult result;
    if (!withheld || !tree_.CanTransform(edge.parent, edge.child)) {
      result = tree_.SetStatic(edge.parent, edge.child, edge.T_parent_child, session_.name());
    }
    if (result && !withheld) (void)NoteStaticOwner(edge.parent, edge.child, session_.id());
    return result;
  };
  auto [taken, refusal] = Take(edges, set);
  sender_.SendStatic(taken, setter);
  return refusal;
}

// The component is about to leave, or to arrive. Without it, or until it looks up its first transform, nothing would
// keep the tree of a session that does not listen up to date.
bool Transforms::Core::Withhold(tf::EdgeSetter& setter) {
  try {
    Listen();
  } catch (const Error& error) {  // Another type: each lookup says so.
    session_.log().Write(LogLevel::kError, error.what());
  }
  const std::vector<StampedEdge> withdrawn = sender_.Withhold(setter);
  for (const StampedEdge& edge : withdrawn) {
    if (const auto child = tree_.Find(edge.child)) owners_.Withdraw(session_.id(), *child);
  }
  if (!withdrawn.empty()) sender_.Flush();
  return !withdrawn.empty();
}

void Transforms::Core::Release(const std::shared_ptr<tf::EdgeSetter>& setter) {
  while (true) {
    std::vector<tf::EdgeSetter::Withheld> edges = sender_.Withheld(*setter);
    const std::size_t count = edges.size();
    std::erase_if(edges, [this](const tf::EdgeSetter::Withheld& one) {
      const StampedEdge& edge = one.edge;
      const SetResult result = tree_.SetStatic(edge.parent, edge.child, edge.T_parent_child, session_.name());
      if (result) return false;
      session_.log().Write(LogLevel::kError, "An edge of a component that has moved here: " + result.text());
      return true;
    });
    if (!sender_.Release(setter, count, edges)) continue;
    for (const auto& [edge, by_constructor] : edges) (void)NoteStaticOwner(edge.parent, edge.child, session_.id());
    return;
  }
}

void Transforms::Core::Receive(const foxglove::FrameTransforms& message, const MessageInfo& info, bool is_static) {
  if (!info.remote && sender_.IsOwn(message)) return;
  const SessionId by{info.id.publisher};
  const std::string publisher = NameOf(by);
  received_ += static_cast<std::uint64_t>(message.transforms_size());
  bool taken = false;
  std::vector<FrameId> still;  // Children of its static edges.
  const Time now = session_.clock()->Now();
  const Moment when = Moment::clock::now();
  for (const foxglove::FrameTransform& transform : message.transforms()) {
    const std::string& parent = transform.parent_frame_id();
    const std::string& child = transform.child_frame_id();
    if (const SetResult result = Store(transform, by, publisher, is_static, now)) {
      if (!is_static) {
        NoteMovingOwner(parent, child, by, when);
      } else if (const auto frame = NoteStaticOwner(parent, child, by)) {
        still.push_back(*frame);
      }
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
  if (is_static && by != session_.id()) owners_.Keep(by, still);
  if (is_static && owners_.is_crowded()) ForgetGone();
  if (taken && options_.on_received) options_.on_received();
}

SetResult Transforms::Core::Store(const foxglove::FrameTransform& transform, SessionId by, std::string_view publisher,
                                  bool is_static, Time now) {
  const std::string& parent = transform.parent_frame_id();
  const std::string& child = transform.child_frame_id();
  const RigidTransform T_parent_child = tf::TransformOf(transform);
  if (is_static) return tree_.SetStatic(parent, child, T_parent_child, publisher);
  if (const auto stamp = tf::StampOf(transform)) {
    return SetChecked(parent, child, *stamp, T_parent_child, by, publisher, now);
  }
  return {SetFault::kTooOld, "The edge " + Edge(parent, child) + " was refused: its timestamp is invalid."};
}

SetResult Transforms::Core::SetChecked(std::string_view parent, std::string_view child, Time stamp,
                                       const RigidTransform& T_parent_child, SessionId by, std::string_view publisher,
                                       Time now) {
  if (SetResult refused = Check(parent, child, stamp, now, by); !refused) return refused;
  const auto set = [&] { return tree_.Set(parent, child, stamp, T_parent_child, publisher); };
  SetResult result = set();
  if (result.jumped_back() && !said_jump_.exchange(true)) {
    session_.log().Write(LogLevel::kWarning,
                         "The stamps of session \"" + std::string(publisher) +
                             "\" jumped back, first those of the edge " + Edge(parent, child) +
                             ", and stayed there for 2 s, so these edges begin again. If a recording is played again, "
                             "play it with a simulated clock: then all edges begin again at once. Further jumps are "
                             "not reported.");
  }
  if (result.fault() != SetFault::kTooOld || now == Time{}) return result;
  if (!tree_.RestartEdge(child, LatestOf(by, now))) return result;
  if (result = set(); result) {
    session_.log().WriteLimited(LogLevel::kWarning, "clock was set back",
                                "The edge " + Edge(parent, child) + " begins again, with a transform of session \"" +
                                    std::string(publisher) +
                                    "\": what it had was stamped by a clock that was ahead and has been set back.");
  }
  return result;
}

Time Transforms::Core::LatestOf(SessionId by, Time now) const {
  const Time limit = Later(now, max_ahead_);
  const auto clock = session_.OffsetTo(by);
  return clock && clock->offset > Duration(0) ? Later(limit, clock->offset + clock->uncertainty) : limit;
}

// A clock that stands at 0 is a simulated one that was not heard yet.
SetResult Transforms::Core::Check(std::string_view parent, std::string_view child, Time stamp, Time now,
                                  SessionId by) const {
  if (now == Time{} || stamp <= Later(now, max_ahead_) || stamp <= LatestOf(by, now)) return {};
  const auto seconds = [](double nanoseconds) { return std::to_string(std::llround(nanoseconds * 1e-9)) + " s"; };
  return {SetFault::kTooNew,
          "The transform " + Edge(parent, child) + " was refused: its stamp is " +
              seconds(static_cast<double>(stamp.nanoseconds) - static_cast<double>(now.nanoseconds)) +
              " ahead of the clock of session \"" + session_.name() + "\", more than max_ahead allows (" +
              seconds(static_cast<double>(max_ahead_.count())) +
              "). Stamp with the session's clock, and synchronize the clocks of the hosts."};
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

void Transforms::Core::NoteMovingOwner(std::string_view parent, std::string_view child, SessionId by, Moment when) {
  const auto frame = tree_.Find(child);
  if (!frame) return;
  if (const auto before = owners_.NoteMoving(*frame, by, when)) TellShared({tree_.Frame(parent), *frame, *before, by});
}

std::optional<FrameId> Transforms::Core::NoteStaticOwner(std::string_view parent, std::string_view child,
                                                         SessionId by) {
  const auto frame = tree_.Find(child);
  const Moment due = Moment::clock::now() + shared_patience_;
  if (frame && owners_.NoteStatic(tree_.Frame(parent), *frame, by, due)) SettleLater();
  return frame;
}

void Transforms::Core::ForgetGone() {
  std::unordered_set<SessionId> there{session_.id()};
  for (const PeerInfo& peer : session_.Peers()) there.insert(peer.id);
  owners_.KeepSessions(there);
}

void Transforms::Core::SettleLater() {
  Timer spent;  // Ends after the lock: its destructor waits for its callback.
  const std::scoped_lock lock(settles_mutex_);
  if (ends_ || std::exchange(settles_, true)) return;
  if (!settle_timers_) settle_timers_.emplace(std::make_shared<SteadyClock>());
  spent = std::exchange(settle_timer_,
                        settle_timers_->After(shared_patience_, [this](const Tick&) { TellSharedStatics(); }));
}

void Transforms::Core::TellSharedStatics() {
  {
    const std::scoped_lock lock(settles_mutex_);
    settles_ = false;
  }
  for (const tf::EdgeOwners::Shared& edge : owners_.TakeShared(Moment::clock::now())) TellShared(edge);
  if (owners_.has_suspects()) SettleLater();
}

void Transforms::Core::TellShared(const tf::EdgeOwners::Shared& edge) {
  if (!IsThere(edge.before) || !IsThere(edge.last) || !owners_.Settle(edge.child)) return;
  session_.log().WriteLimited(LogLevel::kWarning, "shared edge",
                              "Two sessions set the edge " + Edge(tree_.Name(edge.parent), tree_.Name(edge.child)) +
                                  ": " + session_.NameOf(edge.before) + " and " + session_.NameOf(edge.last) +
                                  ". Lookups return either of the two; let only one session set it.");
  ++shared_;
}

TransformsStats Transforms::Core::stats() const {
  return {.sent_messages = sender_.sent_messages(),
          .sent_transforms = sender_.sent_transforms(),
          .unsent_transforms = sender_.unsent_transforms(),
          .received_transforms = received_,
          .refused_transforms = refused_,
          .shared_edges = shared_};
}

}  // namespace hgros
