#include "launch/mover.hpp"

#include <algorithm>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

using Step = RunOrder::Move;

constexpr std::chrono::milliseconds kLookPatience{2'000};
constexpr std::chrono::milliseconds kReceivePatience{20'000};  // It waits for its channels itself.
constexpr std::chrono::milliseconds kHoldPatience{4'000};      // Its callbacks have 1 s.
constexpr std::chrono::milliseconds kMovePatience{5'000};
constexpr std::chrono::milliseconds kQuietPatience{2'000};  // For publishers that publish nothing.
constexpr std::chrono::milliseconds kHandPatience{10'000};
constexpr int kMostDelays = 30;  // For a new place that stands still.
constexpr std::size_t kMostMovingBytes = 8U << 20U;

std::string NamedPlace(const std::string& name) { return "\"" + Visible(name) + "\""; }

std::string Milliseconds(std::chrono::steady_clock::duration time) {
  const auto tenths = std::chrono::duration_cast<std::chrono::microseconds>(time).count() / 100;
  return std::to_string(tenths / 10) + "." + std::to_string(tenths % 10) + " ms";
}

}  // namespace

// --- beginning ---

StartedUnit* Mover::Find(const std::string& process) const {
  const auto found = std::ranges::find_if(means_.units, [&](const auto& one) { return one.setup->name == process; });
  return found == means_.units.end() ? nullptr : &*found;
}

StartedUnit& Mover::PlaceFor(const std::string& to, const StartedUnit& from) const {
  StartedUnit* place = Find(to);
  if (place != nullptr && place->process == nullptr) {
    throw Error(NamedPlace(to) + " is a program. A component can move to a process or a host.");
  }
  if (place == nullptr) {
    std::vector<std::string> names;
    for (const StartedUnit& one : means_.units) {
      if (one.process != nullptr) names.push_back(one.setup->name);
    }
    bool host = false;
    for (const RobotHost& one : means_.robot.hosts) {
      names.push_back(one.name);
      host = host || one.name == to;
    }
    const RobotHost* home = means_.robot.FindHost({});
    const std::string here = home != nullptr && home->name == to ? std::string() : to;
    for (StartedUnit& one : means_.units) {
      if (!host || one.process == nullptr || one.setup->host != here) continue;
      if (place == nullptr || &one == &from || (!place->runs_components() && one.runs_components())) place = &one;
    }
    const std::string nearest = NearestName(to, names);
    if (place == nullptr && host) {
      throw Error("This hgros run has started no process on the host " + NamedPlace(to) + ".", {},
                  "Add one to the robot file: `processes: {NAME: {host: " + Visible(to) +
                      "}}`. With --host, `hgros run` starts none on other hosts.");
    }
    if (place == nullptr) {
      throw Error("This hgros run has started no process " + NamedPlace(to) + ", and the robot has no such host.", {},
                  nearest.empty() ? "`hgros ps` lists them." : "Did you mean " + NamedPlace(nearest) + "?");
    }
  }
  if (place != &from && !place->runs_components()) {
    throw Error("The process " + NamedPlace(place->setup->name) + " does not run now. The component stays in " +
                NamedPlace(from.setup->name) + ".");
  }
  return *place;
}

void Mover::Begin(const std::string& component, const std::string& to) {
  results_.erase(component);
  try {
    const RobotComponent* setup = means_.robot.FindComponent(component);
    if (setup == nullptr) {
      std::vector<std::string> names;
      for (const RobotComponent& one : means_.robot.components) names.push_back(one.setup.name);
      const std::string nearest = NearestName(component, names);
      throw Error("The robot has no component " + NamedPlace(component) + ".", {},
                  nearest.empty() ? "`hgros ps` lists them." : "Did you mean " + NamedPlace(nearest) + "?");
    }
    StartedUnit& from = *Find(setup->process);
    if (const auto ended = from.ended.find(component); ended != from.ended.end()) {
      throw Error(NamedPlace(component) + " has " + ended->second + ".");
    }
    if (!from.runs_components()) throw Error("The process " + NamedPlace(from.setup->name) + " does not run.");
    StartedUnit& place = PlaceFor(to, from);
    if (&place == &from) {
      results_[component] = {true, {}};
      return;
    }
    if (from.alone.contains(component)) throw Error(NamedPlace(component) + " is constructed again at this moment.");
    Move& move = moves_.emplace(component, Move{component, ++attempts_, &from, &place}).first->second;
    if (!MustWait(move)) Look(move);
  } catch (const Error& error) {
    results_[component] = {false, error.what()};
  }
}

std::optional<Mover::Result> Mover::ResultOf(const std::string& component) const {
  const auto found = results_.find(component);
  return found == results_.end() ? std::nullopt : std::optional(found->second);
}

bool Mover::MustWait(const Move& move) const {
  return std::ranges::any_of(moves_, [&](const auto& other) {
    return other.second.stage != Stage::kWaits && means_.graph.Meet(other.first, move.component);
  });
}

void Mover::Look(Move& move) {
  Go(move, Stage::kLooks, kLookPatience);
  Send(*move.from, OrderOf(move, Step::LOOK));
}

void Mover::Go(Move& move, Stage stage, std::chrono::milliseconds limit) {
  move.stage = stage;
  move.limit = Clock::now() + limit;
}

RunOrder::Move Mover::OrderOf(const Move& move, Step::Step step) {
  RunOrder::Move order;
  order.set_component(move.component);
  order.set_step(step);
  order.set_attempt(move.attempt);
  return order;
}

void Mover::Send(StartedUnit& to, const RunOrder::Move& move) {
  if (to.running == nullptr) return;
  RunOrder order;
  *order.mutable_move() = move;
  to.Send(order);
}

// --- steps ---

// As many subscribers and publishers as in the old place, which are others if they are in one of these processes.
void Mover::SendReceive(Move& move, const RunOrder::Move& looked) {
  RunOrder::Move order = OrderOf(move, Step::RECEIVE);
  KeptComponent kept = means_.kept[move.component];
  kept.state = nullptr;
  Write(kept, order);
  const auto here = means_.graph.FindSubscribersOfMoved(move.component, *move.from->process);
  const auto there = means_.graph.FindSubscribersOfMoved(move.component, *move.to->process);
  for (const Step::Users& one : looked.users()) {
    Step::Users& users = *order.add_users();
    users.set_channel(one.channel());
    const std::uint64_t from_file = StartedUnit::CountLasting(here, one.channel(), means_.units);
    const std::uint64_t others = one.subscribers() - std::min<std::uint64_t>(one.subscribers(), from_file);
    users.set_subscribers(StartedUnit::CountLasting(there, one.channel(), means_.units) + others);
    users.set_publishers(one.publishers());
  }
  if (move.stage == Stage::kLooks) Go(move, Stage::kReceives, kReceivePatience);
  Send(*move.to, order);
}

void Mover::SendRestore(Move& move) {
  const KeptComponent& kept = means_.kept[move.component];  // Parameters have changed since the new place got them.
  Write(KeptComponent{move.from_gone ? kept.state : nullptr, kept.params}, move.moving);
  move.moving.MergeFrom(OrderOf(move, Step::RESTORE));
  Go(move, Stage::kRestores, kMovePatience);
  Send(*move.to, move.moving);
  move.moving.Clear();
}

void Mover::Take(const StartedUnit& from, const RunOrder::Move& report) {
  const auto found = moves_.find(report.component());
  if (found == moves_.end() || report.attempt() != found->second.attempt) return TakeLate(from, report);
  Move& move = found->second;
  const bool old = &from == move.from;
  if (!old && &from != move.to) return;
  if (report.step() == Step::FAILED && move.stage < Stage::kHandsOver) return GiveUp(move, report.sentence());
  if (move.stage == Stage::kHandsOver) return Relay(move, from, report);
  if (report.step() == Step::LOOK && (move.stage == Stage::kLooks || move.stage == Stage::kReceives)) {
    if (old) return SendReceive(move, report);
    if (move.stage == Stage::kReceives) Send(*move.from, OrderOf(move, Step::LOOK));  // Its users have changed perhaps.
  } else if (report.step() == Step::RECEIVE && !old && move.stage == Stage::kReceives) {
    if (move.from_gone) return SendRestore(move);
    Go(move, Stage::kHolds, kHoldPatience);
    move.held = Clock::now();
    RunOrder::Move order = OrderOf(move, Step::HOLD);
    order.set_session(report.session());
    Send(*move.from, order);
  } else if (report.step() == Step::HOLD && old && move.stage == Stage::kHolds) {
    if (report.has_state()) means_.kept[move.component].state = StateOf(report.state());
    move.moving = report;
    SendRestore(move);
  } else if (report.step() == Step::RESTORE && !old && move.stage == Stage::kRestores) {
    if (!move.from_gone) Place(move, *move.from, *move.to);
    Go(move, Stage::kBegins, kMovePatience);
    Send(*move.to, OrderOf(move, Step::BEGIN));
  } else if (report.step() == Step::BEGIN && !old && move.stage == Stage::kBegins) {
    HaveBegun(move);
  }
}

// From an old place whose move is over.
void Mover::TakeLate(const StartedUnit& from, const RunOrder::Move& report) {
  if (report.step() == Step::HAND) ++late_[report.component()];
  if (report.step() != Step::LEFT) return;
  if (!report.sentence().empty()) means_.say(from, report.component(), LogLevel::kWarning, report.sentence());
  const auto late = late_.find(report.component());
  if (late == late_.end()) return;
  means_.say(from, report.component(), LogLevel::kWarning,
             std::to_string(late->second) + " messages came too late from its old place, and are lost.");
  late_.erase(late);
}

void Mover::HaveBegun(Move& move) {
  const std::string paused =
      move.from_gone ? "." : ". No message of it was handled for " + Milliseconds(Clock::now() - move.held) + ".";
  means_.say(*move.to, move.component, LogLevel::kInfo,
             "It has moved here from " + NamedPlace(move.from->setup->name) + paused);
  results_[move.component] = {true, {}};
  if (move.from_gone) return TakeLeft(move, {});
  Go(move, Stage::kHandsOver, kQuietPatience);
  Send(*move.from, OrderOf(move, Step::LEAVE));
}

void Mover::Relay(Move& move, const StartedUnit& from, const RunOrder::Move& report) {
  const bool old = &from == move.from;
  if (report.step() == Step::LEFT && old) return TakeLeft(move, report.sentence());
  if (report.step() == Step::HAND && old) Send(*move.to, report);
  if (report.step() == Step::PASSED && !old) Send(*move.from, report);
}

// There is nothing more from the old place.
void Mover::TakeLeft(Move& move, const std::string& sentence) {
  if (!sentence.empty()) means_.say(*move.from, move.component, LogLevel::kWarning, sentence);
  Send(*move.to, OrderOf(move, Step::LEFT));
  moves_.erase(move.component);
}

void Mover::Place(const Move& move, const StartedUnit& from, StartedUnit& to) {
  means_.robot.Place(move.component, to.setup->name);
  if (means_.placed) means_.placed(move.component, to.setup->name);
  StartedUnit& old = *Find(from.setup->name);
  to.runs[move.component] = old.runs[move.component];
  old.runs.erase(move.component);
  old.ended.erase(move.component);
  to.ended.erase(move.component);
}

// --- what goes wrong ---

void Mover::GiveUp(Move& move, const std::string& why) {
  if (move.stage == Stage::kBegins || move.from_gone) {
    Place(move, *move.to, *move.from);
  }
  Send(*move.to, OrderOf(move, Step::DROP));
  if (!move.from_gone) {
    Send(*move.from, OrderOf(move, Step::RESUME));
  } else if (move.from->runs_components()) {
    SendAdopt(move);
  } else if (move.from->running != nullptr) {  // It has begun without the component.
    move.from->again = true;
    move.from->TellToEnd();
  }
  const std::string place = NamedPlace(move.from->setup->name);
  const std::string where = move.from->running != nullptr ? "It runs on in " + place + "."
                            : move.from->stage == UnitStage::kWaits
                                ? "It is started again in " + place + "."
                                : "It runs nowhere, because " + place + " has ended.";
  const std::string sentence = "It was not moved to " + NamedPlace(move.to->setup->name) + ". " + where;
  means_.say(*move.from, move.component, LogLevel::kWarning, sentence + " " + why);
  results_[move.component] = {false, NamedPlace(move.component) + " was not moved to " +
                                         NamedPlace(move.to->setup->name) + ". " + where + " " + why};
  moves_.erase(move.component);
}

void Mover::Disturb(const std::string& component, const std::string& why) {
  const auto found = moves_.find(component);
  if (found == moves_.end() || found->second.stage > Stage::kHolds || found->second.from_gone) return;
  GiveUp(found->second, why);
}

void Mover::NoteEndOfOld(Move& move, const StartedUnit& from) {
  const std::string ended = "Its process " + NamedPlace(from.setup->name) + " has ended.";
  const bool again = from.stage == UnitStage::kWaits;
  switch (move.stage) {
    case Stage::kWaits:
    case Stage::kLooks: return GiveUp(move, ended);
    case Stage::kReceives:
    case Stage::kHolds:
      if (again) return GiveUp(move, ended);
      move.from_gone = true;
      Place(move, *move.from, *move.to);
      if (move.stage == Stage::kHolds) return SendRestore(move);
      return Send(*move.to, OrderOf(move, Step::RECEIVE));  // It waits for none of that process any more.
    case Stage::kRestores:
      if (again) return GiveUp(move, ended);
      move.from_gone = true;
      return Place(move, *move.from, *move.to);
    case Stage::kBegins: move.from_gone = true; return;
    case Stage::kHandsOver: return TakeLeft(move, ended + " Messages that waited there are lost.");
  }
}

void Mover::NoteEndOfNew(Move& move, const StartedUnit& to) {
  const std::string ended = "The process " + NamedPlace(to.setup->name) + " has ended.";
  if (move.stage != Stage::kHandsOver) return GiveUp(move, ended);
  if (to.stage == UnitStage::kWaits || !move.from->runs_components()) {  // It goes on there.
    Send(*move.from, OrderOf(move, Step::DROP));
    moves_.erase(move.component);
    return;
  }
  Place(move, *move.to, *move.from);
  means_.say(*move.from, move.component, LogLevel::kWarning,
             ended + " It is constructed again here, and goes on from the state in which it was moved.");
  SendAdopt(move);
  moves_.erase(move.component);
}

void Mover::SendAdopt(const Move& move) {
  RunOrder::Move order = OrderOf(move, Step::ADOPT);
  Write(means_.kept[move.component], order);
  Send(*move.from, order);
}

void Mover::NoteEnd(const StartedUnit& unit) {
  std::vector<std::string> names;
  for (const auto& [name, move] : moves_) names.push_back(name);
  for (const std::string& name : names) {
    const auto found = moves_.find(name);
    if (found == moves_.end()) continue;
    if (found->second.from == &unit) {
      NoteEndOfOld(found->second, unit);
    } else if (found->second.to == &unit) {
      NoteEndOfNew(found->second, unit);
    }
  }
}

void Mover::HandLate(Move& move) {
  if (move.to->running->stream().unsent() > 0 && ++move.delays <= kMostDelays) {  // It does not read what there is.
    move.limit = Clock::now() + kQuietPatience;
    return;
  }
  if (std::exchange(move.dropped, true)) {
    return TakeLeft(move, "It did not hand its messages over within 10 s. Those that wait there are lost.");
  }
  move.limit = Clock::now() + kHandPatience;
  Send(*move.from, OrderOf(move, Step::DROP));
}

void Mover::Work() {
  std::vector<std::string> late;
  for (const auto& [name, move] : moves_) {
    if (move.limit <= Clock::now()) late.push_back(name);
  }
  for (const std::string& name : late) {
    Move& move = moves_.at(name);
    StartedUnit& silent = move.stage == Stage::kLooks || move.stage == Stage::kHolds ? *move.from : *move.to;
    const std::string& place = silent.setup->name;
    const std::string sentence = "The process " + NamedPlace(place) + " does not answer. `hgros logs " + place +
                                 "` may say why, and `hgros restart " + place + "` starts it again.";
    if (move.stage == Stage::kHandsOver) {
      HandLate(move);
    } else if (move.stage == Stage::kBegins) {  // It may begin at any time.
      move.limit = Clock::time_point::max();
      means_.say(silent, {}, LogLevel::kWarning, "It does not answer, so it ends.");
      silent.TellToEnd();
    } else {
      GiveUp(move, sentence);
    }
  }
  for (auto& [name, move] : moves_) {
    if (move.stage == Stage::kWaits && !MustWait(move)) Look(move);
  }
}

Mover::Clock::time_point Mover::due() const {
  Clock::time_point due = Clock::time_point::max();
  for (const auto& [name, move] : moves_) due = std::min(due, move.limit);
  return due;
}

bool Mover::Congested(const StartedUnit& unit) const {
  return std::ranges::any_of(moves_, [&](const auto& one) {
    const Move& move = one.second;
    return move.from == &unit && move.stage == Stage::kHandsOver && move.to->running != nullptr &&
           move.to->running->stream().unsent() > kMostMovingBytes;
  });
}

}  // namespace hgros::cli
