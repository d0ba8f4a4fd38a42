#include "hosting/component_moves.hpp"

#include <algorithm>
#include <exception>
#include <utility>

#include "hgros/base/error.hpp"
#include "hosting/move_message.hpp"

namespace hgros::cli {
namespace {

using Move = RunOrder::Move;

constexpr std::chrono::seconds kUsersPatience{10};
constexpr std::chrono::seconds kCallbackPatience{1};
constexpr std::chrono::seconds kDroppedPatience{5};     // Until its queues are empty; the starter waits for 10 s.
constexpr std::chrono::milliseconds kUsersPause{2};     // While channels join.
constexpr std::chrono::milliseconds kLookPause{500};    // Some may have gone since they were counted.
constexpr std::chrono::milliseconds kReaderPause{10};   // While the starter reads too slowly.
constexpr std::chrono::milliseconds kPassingPause{10};  // Until messages come to the new place by themselves.

// Of those in this process and in others.
std::size_t SubscribersOf(const Session& session, const std::string& channel) {
  std::size_t count = 0;
  while (session.WaitForSubscribers(channel, count + 1, std::chrono::nanoseconds(0))) ++count;
  return count;
}
std::size_t PublishersOf(const Session& session, const std::string& channel) {
  std::size_t count = 0;
  while (session.WaitForPublishers(channel, count + 1, std::chrono::nanoseconds(0))) ++count;
  return count;
}

}  // namespace

RunReport ComponentMoves::ReportOf(const std::string& name, Move::Step step) const {
  RunReport report;
  report.mutable_move()->set_component(name);
  report.mutable_move()->set_step(step);
  const bool hands = step == Move::HAND || step == Move::LEFT;  // Of the move in which it leaves.
  report.mutable_move()->set_attempt(hands ? leaving_.at(name).attempt : attempts_.at(name));
  return report;
}

void ComponentMoves::Tell(const std::string& name, Move::Step step, const std::string& sentence) {
  RunReport report = ReportOf(name, step);
  report.mutable_move()->set_sentence(sentence);
  reports_.Tell(report);
}

void ComponentMoves::Obey(const Move& order) {
  attempts_[order.component()] = order.attempt();
  try {
    Do(order);
  } catch (const std::exception& error) {
    const std::string& name = order.component();
    if (order.step() == Move::RECEIVE || order.step() == Move::RESTORE || order.step() == Move::BEGIN) {
      arriving_.erase(name);
      hosted_.Forget(name);
    }
    Tell(name, Move::FAILED, error.what());
  }
}

void ComponentMoves::Do(const Move& order) {
  const std::string& name = order.component();
  const auto arriving = arriving_.find(name);
  const auto leaving = leaving_.find(name);
  switch (order.step()) {
    case Move::LOOK: return Look(name);
    case Move::RECEIVE: return Receive(order);
    case Move::HOLD: return Hold(order);
    case Move::RESTORE: return Restore(order);
    case Move::BEGIN: return Begin(name);
    case Move::LEAVE:
      if (leaving == leaving_.end() || leaving->second.place == nullptr) return;
      leaving->second.left = true;
      leaving->second.place->Leave();
      return;
    case Move::HAND:
      if (arriving != arriving_.end() && arriving->second.begun) arriving->second.place->Hand(MessageOf(order));
      return;
    case Move::PASSED:
      if (leaving == leaving_.end() || !leaving->second.left) return;
      for (const Move::Position& one : order.positions()) leaving->second.place->Passed(PositionOf(one));
      return;
    case Move::LEFT:
      if (arriving == arriving_.end() || !arriving->second.begun) return;
      arriving->second.place->Finish();
      arriving_.erase(arriving);
      hosted_.SetMoving(name, false);
      return;
    case Move::RESUME:
      leaving_.erase(name);
      hosted_.SetMoving(name, false);
      return;
    case Move::DROP: return Drop(name);
    case Move::ADOPT:
      if (leaving != leaving_.end()) EndLeaving(name);
      (void)catalog_.Load(robot_.FindComponent(name)->setup.type);
      return hosted_.Adopt(name, KeptOf(order));
    default: return;
  }
}

// --- the old place ---

void ComponentMoves::Look(const std::string& name) {
  const ComponentDescription& component = hosted_.components().description(name);
  if (component.state.empty()) {
    throw Error("Its class cannot be saved, and so it cannot move.", {}, "Give it Save() and Restore().");
  }
  if (!hosted_.Runs(name)) throw Error("It does not run.");
  hosted_.SetMoving(name, true);
  leaving_[name].attempt = attempts_.at(name);
  RunReport report = ReportOf(name, Move::LOOK);
  Move& move = *report.mutable_move();
  for (const ComponentChannel& output : component.outputs) {
    Move::Users& users = *move.add_users();
    users.set_channel(output.channel);
    users.set_subscribers(SubscribersOf(session_, output.channel));
  }
  for (const ComponentChannel& input : component.inputs) {
    leaving_[name].any_type[input.node] = input.type.empty();
    Move::Users& users = *move.add_users();
    users.set_channel(input.channel);
    const bool here = LeavingComponent::HasPublisherHere(hosted_.components(), name, input.channel);
    users.set_publishers(PublishersOf(session_, input.channel) + (here ? 1 : 0));
  }
  reports_.Tell(report);
}

void ComponentMoves::Hold(const Move& order) {
  const std::string& name = order.component();
  Leaving& one = leaving_.at(name);
  if (!hosted_.Runs(name)) throw Error("It does not run any more.");
  auto place = std::make_unique<LeavingComponent>(hosted_.components(), name, [this] { reports_.Wake(); });
  const MovingState moving = place->Hold(kCallbackPatience, SessionId{order.session()});
  std::size_t bytes = moving.state->data.bytes.size();
  for (const MovingLatched& latched : moving.latched) bytes += latched.data.bytes.size();
  if (bytes > kMostStateBytes) {
    const std::string what = moving.latched.empty() ? "Its state has " : "Its state and what it has latched have ";
    throw Error(what + std::to_string(bytes) + " bytes, and the most are " + std::to_string(kMostStateBytes) + ".");
  }
  one.place = std::move(place);
  RunReport report = ReportOf(name, Move::HOLD);
  Write(moving, *report.mutable_move());
  reports_.Tell(report);
}

ComponentMoves::Clock::time_point ComponentMoves::HandOver(const std::string& name, Leaving& one) {
  while (!reports_.full()) {
    const std::optional<MovingMessage> message = one.place->Next();
    if (!message) {
      const bool ends =
          one.dropped_until ? Clock::now() >= *one.dropped_until || !one.place->has_more() : one.place->all_passed();
      if (!ends) return Clock::now() + kPassingPause;
      EndLeaving(name);
      return Clock::time_point::max();
    }
    if (message->message.data.bytes.size() > kMostStateBytes) {
      ++one.lost;
      continue;
    }
    RunReport report = ReportOf(name, Move::HAND);
    Write(*message, one.any_type[message->input], *report.mutable_move());
    reports_.Tell(report);
  }
  return Clock::now() + kReaderPause;
}

void ComponentMoves::EndLeaving(const std::string& name) {
  Leaving& one = leaving_.at(name);
  if (one.place != nullptr) {
    while (one.place->Next()) ++one.lost;  // There are some only if it must end early.
    one.lost += one.place->lost();
  }
  RunReport report = ReportOf(name, Move::LEFT);
  if (one.lost > 0) {
    report.mutable_move()->set_sentence(std::to_string(one.lost) + " messages could not be handed over, and are lost.");
  }
  hosted_.StopTelling(name);
  leaving_.erase(name);
  hosted_.Forget(name);
  reports_.Tell(report);
}

void ComponentMoves::Drop(const std::string& name) {
  if (const auto leaving = leaving_.find(name); leaving != leaving_.end()) {
    leaving->second.dropped_until = Clock::now() + kDroppedPatience;
    return;
  }
  if (arriving_.erase(name) > 0) hosted_.Forget(name);
}

// --- the new place ---

void ComponentMoves::Receive(const Move& order) {
  const std::string& name = order.component();
  if (const auto arriving = arriving_.find(name); arriving != arriving_.end()) {
    const bool waits = arriving->second.deadline != Clock::time_point::max();
    if (waits || order.users().empty()) SetAwaited(order, arriving->second);  // Others, or none any more.
    return;
  }
  if (leaving_.contains(name)) EndLeaving(name);  // Of a move that has been given up.
  const RobotComponent* component = robot_.FindComponent(name);
  if (component == nullptr) throw Error("The robot file has no component of that name here.");
  (void)catalog_.Load(component->setup.type);
  const ComponentSetup setup = hosted_.Expect(*component, KeptOf(order));
  Arriving one;
  one.place = std::make_unique<ArrivingComponent>(hosted_.components(), setup, [this] { reports_.Wake(); });
  one.deadline = Clock::now() + kUsersPatience;
  SetAwaited(order, one);
  arriving_[name] = std::move(one);
}

void ComponentMoves::SetAwaited(const Move& order, Arriving& one) {
  std::vector<Move::Users> awaited(order.users().begin(), order.users().end());
  for (Move::Users& users : awaited) {  // The old place counts this session; it does not count itself.
    if (users.publishers() > 0 && one.place->HasPublisherHere(users.channel())) {
      users.set_publishers(users.publishers() - 1);
    }
    // Counted again, some have gone; those that have come may be this session.
    const auto before = std::ranges::find(one.awaited, users.channel(), &Move::Users::channel);
    if (before == one.awaited.end()) continue;
    users.set_subscribers(std::min(users.subscribers(), before->subscribers()));
    users.set_publishers(std::min(users.publishers(), before->publishers()));
  }
  one.awaited = std::move(awaited);
  if (one.awaited.empty()) one.deadline = Clock::now();
  one.look_again = Clock::now() + kLookPause;
}

bool ComponentMoves::Joined(const Arriving& one, std::string& lacks) const {
  for (const Move::Users& users : one.awaited) {
    const bool subscribed =
        users.subscribers() == 0 ||
        session_.WaitForSubscribers(users.channel(), users.subscribers(), std::chrono::nanoseconds(0));
    const bool published = users.publishers() == 0 ||
                           session_.WaitForPublishers(users.channel(), users.publishers(), std::chrono::nanoseconds(0));
    if (subscribed && published) continue;
    lacks = "Not all " + std::string(subscribed ? "publishers" : "subscribers") + " of the channel \"" +
            users.channel() + "\" were connected after 10 s.";
    return false;
  }
  return true;
}

ComponentMoves::Clock::time_point ComponentMoves::Await(const std::string& name, Arriving& one) {
  if (one.awaited.empty() && one.deadline == Clock::time_point::max()) return Clock::time_point::max();
  std::string lacks;
  if (Joined(one, lacks)) {
    one.awaited.clear();
    one.deadline = Clock::time_point::max();
    RunReport report = ReportOf(name, Move::RECEIVE);
    report.mutable_move()->set_session(session_.id().value);
    reports_.Tell(report);
    return Clock::time_point::max();
  }
  if (Clock::now() < one.deadline) {
    if (Clock::now() >= one.look_again) {
      one.look_again = Clock::time_point::max();
      reports_.Tell(ReportOf(name, Move::LOOK));
    }
    return Clock::now() + kUsersPause;
  }
  Drop(name);
  Tell(name, Move::FAILED, lacks);
  return Clock::now();
}

void ComponentMoves::Restore(const Move& order) {
  Arriving& one = arriving_.at(order.component());
  const MovingState moving = StateOf(order);
  hosted_.TakeParams(order.component(), KeptOf(order));
  one.place->Restore(moving);
  hosted_.Keep(order.component(), moving.state);
  Tell(order.component(), Move::RESTORE);
}

void ComponentMoves::Begin(const std::string& name) {
  Arriving& one = arriving_.at(name);
  one.place->Begin();
  one.begun = true;
  hosted_.Arrive(name);
  Tell(name, Move::BEGIN);
}

// --- both ---

ComponentMoves::Clock::time_point ComponentMoves::Work() {
  Clock::time_point due = Clock::time_point::max();
  std::vector<std::string> names;
  for (const auto& [name, one] : leaving_) {
    if (one.left) names.push_back(name);
  }
  for (const std::string& name : names) due = std::min(due, HandOver(name, leaving_.at(name)));
  names.clear();
  for (const auto& [name, one] : arriving_) names.push_back(name);
  for (const std::string& name : names) {
    Arriving& one = arriving_.at(name);
    if (!one.begun) {
      due = std::min(due, Await(name, one));
      continue;
    }
    if (one.place->Work()) due = Clock::now();
    const std::vector<InputPosition> own = one.place->FirstOwn();
    if (own.empty()) continue;
    RunReport report = ReportOf(name, Move::PASSED);
    for (const InputPosition& position : own) Write(position, *report.mutable_move()->add_positions());
    reports_.Tell(report);
  }
  return due;
}

}  // namespace hgros::cli
