// What a starter shows and tells of its units.
#include <sys/wait.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "launch/robot_client.hpp"
#include "launch/starter.hpp"
#include "processes/process_end.hpp"
#include "terminal/json.hpp"
#include "terminal/records.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

constexpr std::size_t kReportedLines = 10;

}  // namespace

void Starter::ShowStates() {
  Records records(surroundings_.console, {},
                  {{"component", "COMPONENT"}, {"type", "TYPE"}, {"process", "PROCESS"}, {"pid", "PID", true}});
  for (const RobotReply::Unit& unit : statuses()) {
    Json json;
    json.BeginObject().Member("event", "started").Member("process", unit.name());
    if (!unit.host().empty()) json.Member("host", unit.host());
    json.Member("pid", std::int64_t{unit.pid()}).Key("components").BeginList();
    for (const RobotReply::Component& one : unit.components()) {
      if (!unit.program()) json.Value(one.name());
      records.Add({unit.program() ? Cell() : Cell(one.name()), one.type(), PlaceOf(unit), std::int64_t{unit.pid()}});
    }
    if (options_.json) log_.Write(json.EndList().EndObject().text());
  }
  if (!options_.json) log_.Guard([&] { records.End(); });
}

void Starter::Say(const Unit& unit, LogLevel level, const std::string& text) {
  log_.Add({0, unit.setup->name, {}, level, text});
}

void Starter::ReportFailure(Unit& unit, int status) {
  code_ = kFailed;
  const bool itself = WIFEXITED(status) && unit.failed;
  if (!itself) Say(unit, LogLevel::kError, "The process has failed: " + EndText(status) + "." + CoreText(status));
  if (std::exchange(unit.reported, true) || options_.json || itself) return;
  std::vector<const LogLine*> last;
  for (const LogLine& line : lines().all()) {
    if (line.process == unit.setup->name) last.push_back(&line);
  }
  if (last.size() <= 1) return;
  last.pop_back();  // What was said just now.
  log_.Write("The last lines of \"" + Visible(unit.setup->name) + "\":");
  for (std::size_t i = last.size() - std::min(last.size(), kReportedLines); i < last.size(); ++i) {
    log_.Repeat(*last[i]);
  }
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
    told.set_state(ends                            ? "ending"
                   : unit.stage == Stage::kRunning ? "running"
                   : unit.running != nullptr       ? "starting"
                   : unit.stage == Stage::kWaits   ? "waiting"
                                                   : "ended");
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

}  // namespace hgros::cli
