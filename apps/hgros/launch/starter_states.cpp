// What a starter shows and tells of its units.
#include <sys/wait.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "launch/starter.hpp"
#include "processes/process_end.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

constexpr std::size_t kReportedLines = 10;

}  // namespace

void Starter::ReportFailure(Unit& unit, int status) {
  code_ = kFailed;
  const bool itself = WIFEXITED(status) && unit.failed;
  if (!itself) {
    const std::string early = status == 0 ? ", but its components had not ended" : "";
    Say(unit, LogLevel::kError,
        "The process has failed: " + EndText(status) + early + "." + CoreText(status, unit.running->pid()));
  }
  if (std::exchange(unit.reported, true) || options_.json || itself) return;
  std::vector<const LogLine*> last;
  for (const LogLine& line : lines().all()) {
    if (line.process == unit.setup->name) last.push_back(&line);
  }
  if (last.size() <= 1) return;
  last.pop_back();  // What was said just now.
  log_.Write("The last lines of \"" + unit.setup->name + "\":");
  for (std::size_t i = last.size() - std::min(last.size(), kReportedLines); i < last.size(); ++i) {
    log_.Repeat(*last[i]);
  }
}

void Starter::Say(const Unit& unit, LogLevel level, const std::string& text) {
  log_.Add({0, unit.setup->name, {}, level, text});
}

std::vector<RobotReply::Unit> Starter::statuses() const {
  std::vector<RobotReply::Unit> all;
  for (const Unit& unit : units_) {
    RobotReply::Unit& told = all.emplace_back();
    told.set_name(unit.setup->name);
    told.set_program(unit.program != nullptr);
    if (options_.remote != nullptr) told.set_host(unit.setup->host);
    told.set_restarts(unit.starts == 0 ? 0 : unit.starts - 1);
    const bool ends = unit.running != nullptr && (unit.again || unit.stage == Stage::kEnds);
    told.set_state(ends                                      ? "ending"
                   : unit.stage == Stage::kRunning           ? "running"
                   : unit.running != nullptr                 ? "starting"
                   : unit.stage == Stage::kWaits && !ending_ ? (unit.unreached ? "unreachable" : "waiting")
                   : unit.starts == 0                        ? "not started"
                                                             : ShortEndText(unit.status));
    if (unit.running != nullptr) {
      told.set_pid(unit.running->pid());
      told.set_seconds(std::chrono::duration<double>(Clock::now() - unit.started).count());
    }
    if (unit.program != nullptr) {
      std::string command;
      for (const std::string& word : unit.program->command) command += (command.empty() ? "" : " ") + word;
      told.add_components()->set_type(command);
      continue;
    }
    for (const std::string& name : unit.process->components) {
      RobotReply::Component& component = *told.add_components();
      component.set_name(name);
      component.set_type(robot_.FindComponent(name)->setup.type);
      if (const auto runs = unit.runs.find(name); runs != unit.runs.end()) component.set_starts(runs->second);
      const auto ended = unit.ended.find(name);
      component.set_state(ended == unit.ended.end() ? told.state() : ended->second);
    }
  }
  return all;
}

std::string Starter::UnitOf(const std::string& name) const {
  if (std::ranges::any_of(units_, [&](const Unit& unit) { return unit.setup->name == name; })) return name;
  const RobotComponent* component = robot_.FindComponent(name);
  return component == nullptr ? std::string() : component->process;
}

void Starter::Move(const std::string& component, const std::string& to) {
  if (!ending_) mover_.Begin(component, to);
}

bool Starter::Starts(const std::string& unit) const {
  return std::ranges::any_of(
      units_, [&](const Unit& one) { return one.setup->name == unit && (one.again || one.stage == Stage::kJoined); });
}

std::optional<std::uint64_t> Starter::RestartAlone(const std::string& component) {
  const auto unit = std::ranges::find(units_, UnitOf(component), [](const Unit& one) { return one.setup->name; });
  if (unit == units_.end() || unit->stage != Stage::kRunning || unit->again || ending_) return std::nullopt;
  unit->ended.erase(component);
  unit->AwaitAlone(component);
  RunOrder order;
  order.mutable_again()->set_component(component);
  unit->Send(order);
  return unit->runs[component];
}

}  // namespace hgros::cli
