#include "launch/started_unit.hpp"

#include <signal.h>

#include <algorithm>

namespace hgros::cli {
namespace {

// What runs on another host is killed there, and that is told. States come over a network.
constexpr std::chrono::milliseconds kRelayedEndPatience = kEndPatience + std::chrono::seconds(1);
constexpr std::chrono::seconds kRelayedStatePatience{30};

}  // namespace

void StartedUnit::AddTo(std::vector<pollfd>& watched, bool reads) const {
  if (over_at == Clock::time_point::max()) watched.push_back({running->end_descriptor(), POLLIN, 0});
  const int events = (running->stream().unsent() > 0 ? POLLOUT : 0) | (reads ? POLLIN : 0);
  if (!running->stream_ended()) watched.push_back({running->stream().descriptor(), static_cast<short>(events), 0});
  if (running->output() >= 0) watched.push_back({running->output(), POLLIN, 0});
}

std::string StartedUnit::WhatIsLate(bool joining, bool released) const {
  if (stage == UnitStage::kBegun) return "It still constructs its components.";
  if (stage == UnitStage::kConstructed && joining) return "It still waits for its subscribers.";
  return stage == UnitStage::kJoined && released ? "An Activate() of its components has not returned." : "";
}

void StartedUnit::Send(const RunOrder& order) {
  running->stream().Add(order);
  (void)running->stream().Write();  // If nobody reads it, the end of the process follows.
}

std::size_t StartedUnit::CountLasting(const RobotGraph::Subscribers& subscribers,
                                      const std::vector<StartedUnit>& units) {
  const auto gone = [&](const StartedUnit& one) {
    return (one.stage == UnitStage::kEnded || one.unreached) && subscribers.elsewhere.contains(one.setup->name);
  };
  return subscribers.count() - static_cast<std::size_t>(std::ranges::count_if(units, gone));
}

std::uint64_t StartedUnit::CountLasting(const std::map<std::string, RobotGraph::Subscribers>& subscribers,
                                        const std::string& channel, const std::vector<StartedUnit>& units) {
  const auto found = subscribers.find(channel);
  return found == subscribers.end() ? 0 : CountLasting(found->second, units);
}

void StartedUnit::Join(const RobotGraph& graph, const std::vector<StartedUnit>& units) {
  RunOrder order;
  RunOrder::Join& join = *order.mutable_join();
  for (const auto& [channel, subscribers] : graph.FindSubscribers(*process)) {
    RunOrder::Output& output = *join.add_outputs();
    output.set_channel(channel);
    output.set_subscribers(CountLasting(subscribers, units));
    for (const StartedUnit& one : units) {
      if (subscribers.elsewhere.contains(one.setup->name) && one.has_joined()) output.set_ready(output.ready() + 1);
    }
  }
  Send(order);
}

void StartedUnit::Release() {
  RunOrder order;
  (void)order.mutable_start();
  Send(order);
}

// --- its end ---

void StartedUnit::TellToEnd(Clock::time_point latest) {
  const bool saves = again && process != nullptr;
  std::chrono::milliseconds patience = remote ? kRelayedEndPatience : kEndPatience;
  if (saves) patience = remote ? kRelayedStatePatience : kStatePatience;
  kill_at = std::min(latest, Clock::now() + patience);
  if (program != nullptr) return running->Signal(SIGTERM);
  RunOrder order;
  order.mutable_end()->set_save(saves);
  Send(order);
  if (!remote && !saves) (void)running->AskToEnd();  // A component may hang.
}

void StartedUnit::AwaitState() {
  if (again && kill_at != Clock::time_point::max()) kill_at = std::max(kill_at, Clock::now() + kStatePatience);
}

void StartedUnit::AwaitEnd() {
  if (remote) return;  // Its host does so. To end the relay before that is told would cost more time.
  kill_at = std::min(kill_at, Clock::now() + kEndPatience);
  (void)running->AskToEnd();
}

void StartedUnit::EndHanging(Clock::time_point latest) {
  again = true;
  TellToEnd(latest);
  AwaitEnd();
}

bool StartedUnit::AskLate() {
  if (process == nullptr || remote || !running->AskToEnd()) return false;
  kill_at = Clock::now() + kEndPatience;
  return true;
}

bool StartedUnit::MayRunOn(std::chrono::seconds most) {
  if (!remote || over) return false;
  if (over_at == Clock::time_point::max()) over_at = Clock::now() + most;
  return Clock::now() < over_at;
}

// --- components that are constructed again alone ---

void StartedUnit::AwaitAlone(const std::string& component) {
  alone[component] = Clock::now() + kStatePatience;
  KillIfLate();
}

void StartedUnit::NoteAlone(const std::string& component) {
  if (alone.erase(component) > 0) KillIfLate();
}

void StartedUnit::KillIfLate() {
  if (stage == UnitStage::kEnds || again) return;
  kill_at = Clock::time_point::max();
  for (const auto& [component, latest] : alone) kill_at = std::min(kill_at, latest);
}

bool StartedUnit::MissedAgain() const {
  return process != nullptr && !alone.empty() && std::ranges::all_of(process->components, [this](const auto& one) {
           return ended.contains(one) || alone.contains(one);
         });
}

}  // namespace hgros::cli
