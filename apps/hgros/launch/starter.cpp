#include "launch/starter.hpp"

#include <poll.h>
#include <signal.h>
#include <sys/wait.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "hgros/base/error.hpp"
#include "hosting/hosted_process.hpp"
#include "processes/process_end.hpp"
#include "remote/remote_units.hpp"
#include "terminal/pause.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

constexpr std::chrono::seconds kLateStart{15};             // A start that takes longer is said to be late.
constexpr std::chrono::milliseconds kReaderPatience{200};  // Robots must not wait for a pager.
constexpr std::size_t kWidestName = 16;

std::size_t WidthOfNames(const RobotFile& robot) {
  std::size_t width = 0;
  for (const RobotProcess& one : robot.processes) width = std::max(width, one.name.size());
  for (const RobotProgram& one : robot.programs) width = std::max(width, one.name.size());
  for (const RobotComponent& one : robot.components) width = std::max(width, one.setup.name.size());
  return std::min(width, kWidestName);
}

std::string Named(const std::string& name) { return "\"" + Visible(name) + "\""; }

}  // namespace

Starter::Starter(RobotFile robot, const RobotGraph& graph, const ComponentCatalog& catalog, Surroundings& surroundings,
                 StarterOptions options)
    : robot_(std::move(robot)),
      graph_(graph),
      catalog_(catalog),
      surroundings_(surroundings),
      options_(std::move(options)),
      clients_(*this, options_.name),
      log_(surroundings.console, {options_.json, options_.verbose, WidthOfNames(robot_)}),
      mover_({robot_, graph_, units_, kept_, options_.on_placed,
              [this](const Unit& unit, const std::string& component, LogLevel level, const std::string& text) {
                log_.Add({0, unit.setup->name, component, level, text});
              }}) {
  for (const RobotProcess& process : robot_.processes) units_.push_back({&process, &process, nullptr});
  for (const RobotProgram& program : robot_.programs) units_.push_back({&program, nullptr, &program});
  log_.Tell([this](const LogLine& line) { clients_.Tell(line); });
}

int Starter::Run() {
  surroundings_.pause.OutlastTheSecond();  // It kills them; this process must not leave before.
  while (!AllEnded()) {
    try {
      if (!ending_) StartDue();
      Advance();
      Poll();
      log_.WaitAtMost(kReaderPatience);
      for (Unit& unit : units_) Hear(unit);
      KillLate();
      if (!ending_) mover_.Work();
      EndEmpty();
      clients_.Serve();
      if (surroundings_.pause.signal() != 0) EndAll({}, code_);
    } catch (const OutputClosed&) {
      log_.Silence();
      EndAll({}, code_);
    }
    if (surroundings_.pause.signaled_again() && !std::exchange(at_once_, true)) kill_at_ = Clock::now();
    if (ending_) EndNext();
  }
  clients_.TellEnd(code_, options_.keeps_report);
  log_.End();
  return code_;
}

// --- starting ---

void Starter::StartDue() {
  for (Unit& unit : units_) {
    if (unit.stage != Stage::kWaits || unit.due > Clock::now()) continue;
    if (unit.program != nullptr && !released_) continue;  // Programs follow the components.
    try {
      Start(unit);
    } catch (const Error& error) {
      Say(unit, LogLevel::kError, error.what());
      if (!released_) return EndAll({}, kFailed);
      unit.stage = Stage::kEnded;
      StartAgain(unit);  // There may be room later.
    }
  }
}

void Starter::Start(Unit& unit) {
  unit.ended.clear();
  const bool remote = unit.remote = options_.remote != nullptr && !unit.setup->host.empty();
  unit.over = unit.unreached = false;
  unit.over_at = Clock::time_point::max();
  RobotUnit relay;  // What the file says is for the other host.
  relay.name = unit.setup->name;
  relay.at = unit.setup->at;
  unit.running = std::make_unique<UnitProcess>(remote ? relay : *unit.setup, guard_, [&](int socket) {
    if (remote) return options_.remote->Run(socket, *unit.setup, kept_);
    if (unit.program != nullptr) return BecomeProgram(*unit.program);
    return HostComponents(socket, robot_, *unit.process, catalog_, kept_);
  });
  unit.stage = unit.program != nullptr ? Stage::kRunning : Stage::kBegun;
  unit.started = Clock::now();
  late_at_ = unit.started + kLateStart;
  ++unit.starts;
}

void Starter::SayWhatIsLate() {
  if (Clock::now() < late_at_) return;
  late_at_ = Clock::time_point::max();
  for (const Unit& unit : units_) {
    const std::string late = unit.WhatIsLate(joining_, released_);
    if (!late.empty()) Say(unit, LogLevel::kWarning, late + (released_ ? "" : " The robot waits for it."));
  }
}

void Starter::Advance() {
  if (ending_) return;
  SayWhatIsLate();
  if (released_) {
    const bool tells = options_.on_running && std::ranges::none_of(units_, &Unit::begins);
    return tells ? std::exchange(options_.on_running, nullptr)() : void();
  }
  const auto all = [this](Stage stage) {
    return std::ranges::all_of(units_, [stage](const Unit& unit) {
      return unit.program != nullptr || (unit.stage >= stage && unit.stage < Stage::kEnds);
    });
  };
  if (!joining_ && all(Stage::kConstructed)) {
    joining_ = true;
    for (Unit& unit : units_) {
      if (unit.process != nullptr) unit.Join(graph_, units_);
    }
  }
  if (joining_ && all(Stage::kJoined)) {
    released_ = true;
    late_at_ = Clock::now() + kLateStart;
    for (Unit& unit : units_) {
      if (unit.process != nullptr) unit.Release();
    }
    StartDue();
    if (ending_) return;
    log_.ShowStates(statuses());
  }
}

// --- hearing ---

Starter::Clock::time_point Starter::NextDue() const {
  Clock::time_point due = std::min(kill_at_, ending_ ? kill_at_ : std::min(late_at_, mover_.due()));
  if (together_at_ > Clock::time_point::min()) due = std::min(due, together_at_);
  for (const Unit& unit : units_) {
    const bool waits = unit.stage == Stage::kWaits && !ending_ && (unit.process != nullptr || released_);
    if (waits) due = std::min(due, unit.due);
    due = std::min({due, unit.kill_at, unit.over_at});
  }
  return due;
}

void Starter::Poll() {
  std::vector<pollfd> watched{{surroundings_.pause.ended(), POLLIN, 0}};
  if (ending_) watched.clear();  // A signal that came just now must wake this.
  for (const Unit& unit : units_) {
    if (unit.running == nullptr) continue;
    unit.AddTo(watched, !mover_.Congested(unit));
  }
  clients_.AddTo(watched);
  const Clock::time_point due = NextDue();
  timespec time{};
  if (due != Clock::time_point::max()) {
    const auto left = std::max(due - Clock::now(), Clock::duration::zero());
    time.tv_sec = std::chrono::duration_cast<std::chrono::seconds>(left).count();
    time.tv_nsec = std::chrono::nanoseconds(left % std::chrono::seconds(1)).count();
  }
  const int ready = ppoll(watched.data(), watched.size(), due == Clock::time_point::max() ? nullptr : &time, nullptr);
  if (ready < 0 && errno != EINTR) throw Error("The system refused to wait for the robot's processes.");
}

void Starter::Hear(Unit& unit) {
  if (unit.running == nullptr) return;
  UnitProcess& running = *unit.running;
  const bool ended = running.HasEnded();  // Before reading, so that nothing it has said is left.
  if (running.stream().unsent() > 0) (void)running.stream().Write();
  if (!running.stream_ended() && (ended || !mover_.Congested(unit))) {
    const bool more = running.stream().Read();
    RunReport report;
    while (running.stream().Next(report)) Take(unit, report);
    if (running.stream().receives_large()) unit.AwaitState();
    if (!more) running.EndStream();
  }
  const auto hear = [&](std::string_view line) {
    log_.Add({0, unit.setup->name, {}, LogLevel::kInfo, std::string(line)});
  };
  running.ReadOutput(hear);
  if (!ended) return;
  running.ReadLastLine(hear);
  if (unit.MayRunOn(kFarEnd) && !ending_) return;  // Another instance may run only afterwards.
  unit.over_at = Clock::time_point::max();
  TakeEnd(unit);
}

void Starter::Take(Unit& unit, const RunReport& report) {
  switch (report.report_case()) {
    case RunReport::kStage:
      if (report.stage() == RunReport::SAVING) return unit.AwaitState();
      if (report.stage() == RunReport::SAVED) return unit.AwaitEnd();
      if (unit.stage == Stage::kEnds) return;
      unit.stage = report.stage() == RunReport::CONSTRUCTED ? Stage::kConstructed
                   : report.stage() == RunReport::JOINED    ? Stage::kJoined
                                                            : Stage::kRunning;
      if (!released_) return;  // Advance() lets all go on together.
      if (unit.stage == Stage::kConstructed) unit.Join(graph_, units_);
      if (unit.stage == Stage::kJoined) unit.Release();
      return;
    case RunReport::kComponent: return TakeComponent(unit, report.component());
    case RunReport::kSaved: kept_[report.saved().component()].state = StateOf(report.saved()); return;
    case RunReport::kChanged: return kept_[report.changed().component()].Note(report.changed());
    case RunReport::kMove: return mover_.Take(unit, report.move());
    case RunReport::kOver: unit.over = true; return;
    case RunReport::kUnreached: unit.over = unit.unreached = true; return;
    case RunReport::kLine:
      return log_.Add({report.line().time_ns(), unit.setup->name, report.line().component(),
                       static_cast<LogLevel>(std::clamp(report.line().level(), 0, 3)), report.line().text()});
    case RunReport::kFault: return Say(unit, LogLevel::kError, report.fault());
    case RunReport::kLacks:
      return Say(
          unit, LogLevel::kWarning,
          "Not all subscribers of " + report.lacks() + " were connected after 10 s. They miss the first messages.");
    case RunReport::kLost:
      return Say(
          unit, LogLevel::kWarning,
          std::to_string(report.lost()) + " lines of the log were lost, because hgros run did not read them in time.");
    case RunReport::REPORT_NOT_SET: return;
  }
}

void Starter::TakeComponent(Unit& unit, const RunReport::Component& component) {
  const auto state = static_cast<ComponentState>(component.state());
  const bool failed = state == ComponentState::kFailed;
  const auto say = [&](LogLevel level, const std::string& what) {
    log_.Add({0, unit.setup->name, component.name(), level,
              what + (component.sentence().empty() ? "." : ": " + component.sentence())});
  };
  const RobotComponent* setup = robot_.FindComponent(component.name());
  if (setup == nullptr || setup->process != unit.setup->name) return;  // It has moved.
  if (state != ComponentState::kRunning) mover_.Disturb(component.name(), "It has ended.");
  if (component.again()) {
    code_ = kFailed;
    if (!unit.alone.contains(component.name())) unit.AwaitAlone(component.name());
    return say(LogLevel::kError, "It is constructed again, because it has failed");
  }
  if (!component.changed()) return;
  if (state >= ComponentState::kRunning) unit.NoteAlone(component.name());
  if (state == ComponentState::kRunning) {
    unit.ended.erase(component.name());
    if (!mover_.Moves(component.name())) ++unit.runs[component.name()];
  }
  if (!failed && state != ComponentState::kFinished) return;
  const bool first = unit.ended.emplace(component.name(), failed ? "failed" : "finished").second;
  if (!first) return;
  say(failed ? LogLevel::kError : LogLevel::kInfo, failed ? "It has failed" : "It has finished");
  if (failed) {
    unit.failed = true;
    code_ = kFailed;
  }
  if (setup->essential && !ending_) {
    EndAll(failed ? "The robot ends, because " + Named(component.name()) + " is essential." : "", code_);
  } else if (failed && !ending_ && released_ && unit.setup->restart != RestartPolicy::kNever) {
    unit.TellToEnd(kill_at_);  // TakeEnd() starts it again.
  }
}

void Starter::TakeEnd(Unit& unit) {
  TakeStatus(unit);
  if (!ending_) mover_.NoteEnd(unit);
}

void Starter::TakeStatus(Unit& unit) {
  const int status = unit.status = unit.running->status();
  const bool well = WIFEXITED(status) && WEXITSTATUS(status) == 0;
  unit.again = unit.again || (well && unit.MissedAgain());
  unit.alone.clear();
  const bool told = unit.stage == Stage::kEnds || unit.again;
  const bool left = unit.process != nullptr && unit.ended.size() < unit.process->components.size();
  const bool failed = unit.failed || left || !well;
  const bool early = !released_ && !told;
  if (told ? !unit.remote && HasCrashed(status, unit.process != nullptr) : failed) ReportFailure(unit, status);
  unit.running.reset();
  unit.stage = Stage::kEnded;
  unit.kill_at = Clock::time_point::max();
  if (std::exchange(unit.again, false) && !ending_) {
    unit.failed = false;
    unit.stage = Stage::kWaits;
    unit.due = Clock::now();
  }
  if (told || ending_) return;
  if (early) return EndAll("The robot cannot start without " + Named(unit.setup->name) + ".", kFailed);
  const RestartPolicy policy = unit.setup->restart;
  if (policy == RestartPolicy::kAlways || (policy == RestartPolicy::kOnFailure && failed)) StartAgain(unit);
  if (unit.stage == Stage::kEnded && unit.setup->essential) {
    EndAll(failed ? "The robot ends, because " + Named(unit.setup->name) + " is essential." : "", code_);
  }
}

void Starter::StartAgain(Unit& unit) {
  const auto pause = unit.unreached ? std::optional(unit.restarts.NextAttempt()) : unit.restarts.Next(Clock::now());
  if (!pause) {
    return Say(
        unit, LogLevel::kError,
        "It was started again " + std::to_string(RestartPauses::kMost) + " times within a minute, and now is not.");
  }
  unit.failed = false;
  unit.due = Clock::now() + *pause;
  unit.stage = Stage::kWaits;
  Say(unit, LogLevel::kWarning,
      pause->count() == 0 ? "It is started again."
                          : "It is started again in " + std::to_string(pause->count()) + " ms.");
}

std::uint64_t Starter::Restart(const std::string& unit) {
  const auto found = std::ranges::find_if(units_, [&](const Unit& one) { return one.setup->name == unit; });
  const std::uint64_t before = found->starts == 0 ? 0 : found->starts - 1;
  if (ending_ || !released_ || found->again) return before;
  found->restarts.Forget();
  if (found->running != nullptr) {
    found->again = true;
    found->TellToEnd();
  } else {
    found->failed = false;
    found->stage = Stage::kWaits;
    found->due = Clock::now();
  }
  return before;
}

}  // namespace hgros::cli
