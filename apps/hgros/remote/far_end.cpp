#include "remote/far_end.hpp"

#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <map>
#include <utility>

#include "hgros/base/error.hpp"
#include "hosting/hosted_process.hpp"
#include "launch/host_networks.hpp"
#include "processes/process_end.hpp"
#include "remote/remote_units.hpp"
#include "terminal/console.hpp"
#include "terminal/pause.hpp"
#include "trial/component_trial.hpp"

namespace hgros::cli {
namespace {

constexpr std::size_t kFarUnsentBytes = 1U << 20U;  // Then the unit waits.
constexpr int kFailedStatus = 1 << 8;               // The wait status of exit code 1.

int NonBlocking(int descriptor) {
  const int copy = fcntl(descriptor, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
  if (copy < 0) throw Error("This command is run by `hgros run` on another host.");
  (void)fcntl(copy, F_SETFL, fcntl(copy, F_GETFL) | O_NONBLOCK);
  return copy;
}

}  // namespace

FarEnd::FarEnd(Pause& pause) : pause_(pause), orders_(NonBlocking(STDIN_FILENO)), reports_(NonBlocking(STDOUT_FILENO)) {
  (void)dup2(STDERR_FILENO, STDOUT_FILENO);  // Reports have it for themselves.
  RemoteReport hello;
  hello.set_version(HGROS_VERSION);
  Tell(hello);
}

FarEnd::~FarEnd() = default;

bool FarEnd::over() const { return gone_ || pause_.signal() != 0; }

int FarEnd::Run() {
  while (!start_ && !over()) Wait();
  if (!start_) throw Error("No robot came from standard input. `hgros run` starts this command, over ssh.");
  try {
    if (ends_) {
      TellEnd(0);  // It has not begun.
    } else {
      Start();
    }
  } catch (const OutputClosed&) {
    return 1;
  } catch (const std::exception& error) {
    RemoteReport report;
    report.mutable_run()->set_fault(error.what());
    Tell(report);
    TellEnd(kFailedStatus);
  }
  while (unit_ != nullptr) {
    const bool ended = unit_->HasEnded();  // Before reading, so that nothing it has said is left.
    HearUnit(ended);
    if (ended) {
      TellEnd(std::exchange(unit_, nullptr)->status());
      break;
    }
    if (over()) EndUnit();  // Before waiting: what was read of the unit may have shown that nobody listens.
    Wait();
    if (Clock::now() < kill_at_) continue;
    if (process_ != nullptr && unit_->AskToEnd()) {  // Its main thread may hang.
      kill_at_ = Clock::now() + kEndPatience;
    } else {
      unit_->Signal(SIGKILL);
    }
  }
  while (reports_.unsent() > 0 && !over()) Wait();
  return over() ? 1 : 0;
}

// --- starting ---

void FarEnd::Start() {
  if (!start_->domain().empty()) (void)setenv("HGROS_DOMAIN", start_->domain().c_str(), 1);
  RobotFileOptions options;
  options.host = start_->host();
  CheckedRobotFile checked = RobotFile::Check(yaml::Document::Parse(start_->robot(), start_->file()), options);
  if (!checked.faults.empty()) throw checked.faults.front();
  std::map<std::string, std::string> networks;
  if (!start_->network().empty()) networks[start_->unit()] = start_->network();
  for (const std::string& name : start_->components()) checked.robot.Place(name, start_->unit());
  robot_ = PartOfHost(checked.robot, start_->host(), networks);
  robot_.components = checked.robot.components;  // One of another host may move here.
  const RobotUnit* setup = nullptr;
  for (RobotProcess& one : robot_.processes) {
    if (one.name != start_->unit()) continue;
    one.components.assign(start_->components().begin(), start_->components().end());  // Not those that have left.
    process_ = &one;
    setup = &one;
  }
  const RobotProgram* program = nullptr;
  for (const RobotProgram& one : robot_.programs) {
    if (one.name == start_->unit()) setup = program = &one;
  }
  if (setup == nullptr) throw Error("The robot has no \"" + start_->unit() + "\" here.");
  if (process_ != nullptr) CheckLibraries(*process_);
  unit_ = std::make_unique<UnitProcess>(*setup, guard_, [&](int socket) {
    return program != nullptr ? BecomeProgram(*program) : HostComponents(socket, robot_, *process_, catalog_, kept_);
  });
}

void FarEnd::CheckLibraries(const RobotProcess& process) const {
  std::vector<ComponentSetup> setups;
  for (const std::string& name : process.components) setups.push_back(robot_.FindComponent(name)->setup);
  std::vector<std::string> faults;
  std::vector<ComponentDescription> descriptions;
  for (TriedComponent& one : TryComponents(setups, catalog_, pause_)) {
    if (one.description) {
      descriptions.push_back(*std::move(one.description));
    } else {
      for (const Error& fault : one.faults) faults.emplace_back(fault.what());
    }
  }
  std::string mend;
  if (faults.empty()) {
    faults = LibraryDifferences(*start_, descriptions, catalog_);
    mend = "Install the same libraries on both hosts.";
  }
  if (faults.empty()) return;
  std::string all;
  for (const std::string& one : faults) all += (all.empty() ? "" : " ") + one;
  throw Error(all, {}, mend);
}

// --- running ---

void FarEnd::Wait() {
  const bool room = reports_.unsent() < kFarUnsentBytes;
  std::vector<pollfd> watched{{gone_ ? -1 : orders_.descriptor(), POLLIN, 0},
                              {reports_.unsent() > 0 && !gone_ ? reports_.descriptor() : -1, POLLOUT, 0},
                              {pause_.signal() != 0 ? -1 : pause_.ended(), POLLIN, 0}};
  if (unit_ != nullptr) {
    watched.push_back({unit_->end_descriptor(), POLLIN, 0});
    const int events = (unit_->stream().unsent() > 0 ? POLLOUT : 0) | (room ? POLLIN : 0);
    if (!unit_->stream_ended()) watched.push_back({unit_->stream().descriptor(), static_cast<short>(events), 0});
    if (room && unit_->output() >= 0) watched.push_back({unit_->output(), POLLIN, 0});
  }
  const Clock::time_point due = std::min(gone_ ? Clock::time_point::max() : heard_ + kFarSilence, kill_at_);
  int wait_ms = -1;
  if (due != Clock::time_point::max()) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(due - Clock::now()).count();
    wait_ms = static_cast<int>(std::max<std::int64_t>(left, 0));
  }
  if (poll(watched.data(), watched.size(), wait_ms) < 0 && errno != EINTR) gone_ = true;
  if (!gone_ && watched[1].revents != 0 && !reports_.Write()) gone_ = true;
  if (!gone_) HearStarter();
}

void FarEnd::HearStarter() {
  const bool more = orders_.Read();
  RemoteOrder order;
  while (orders_.Next(order)) {
    heard_ = Clock::now();
    switch (order.order_case()) {
      case RemoteOrder::kSaved: kept_[order.saved().component()].state = StateOf(order.saved()); break;
      case RemoteOrder::kChanged: kept_[order.changed().component()].Note(order.changed()); break;
      case RemoteOrder::kStart:
        if (!start_) start_ = order.start();
        break;
      case RemoteOrder::kRun: Obey(order.run()); break;
      case RemoteOrder::ORDER_NOT_SET: break;
    }
  }
  if (!more || Clock::now() - heard_ > kFarSilence) gone_ = true;
}

void FarEnd::Obey(const RunOrder& order) {
  ends_ = ends_ || order.has_end();
  if (unit_ == nullptr) return;
  if (order.has_end()) {
    kill_at_ = std::min(kill_at_, Clock::now() + (order.end().save() ? kStatePatience : kEndPatience));
  }
  if (process_ == nullptr) {
    if (order.has_end()) unit_->Signal(SIGTERM);
    return;
  }
  unit_->stream().Add(order);
  (void)unit_->stream().Write();  // If nobody reads it, the end of the process follows.
  if (order.has_end() && !order.end().save()) (void)unit_->AskToEnd();  // A component may hang.
}

void FarEnd::EndUnit() {
  if (kill_at_ <= Clock::now() + kEndPatience) return;
  RunOrder order;
  (void)order.mutable_end();
  Obey(order);
}

void FarEnd::HearUnit(bool ended) {
  if (unit_->stream().unsent() > 0) (void)unit_->stream().Write();
  if (!ended && !gone_ && reports_.unsent() >= kFarUnsentBytes) return;
  if (!unit_->stream_ended()) {
    const bool more = unit_->stream().Read();
    bool saves = unit_->stream().receives_large();
    bool saved = false;
    RemoteReport report;
    while (unit_->stream().Next(*report.mutable_run())) {
      saves = saves || report.run().stage() == RunReport::SAVING;
      saved = saved || report.run().stage() == RunReport::SAVED;
      Tell(report);
    }
    if (saves && !over() && kill_at_ != Clock::time_point::max()) kill_at_ = Clock::now() + kStatePatience;
    if (saved && unit_->AskToEnd()) kill_at_ = std::min(kill_at_, Clock::now() + kEndPatience);
    if (!more) unit_->EndStream();
  }
  const auto hear = [this](std::string_view line) {
    RemoteReport report;
    report.set_printed(std::string(line));
    Tell(report);
  };
  unit_->ReadOutput(hear);
  if (!ended) return;
  unit_->ReadLastLine(hear);
  if (const std::string core = CoreText(unit_->status(), unit_->pid()); !core.empty()) hear(core.substr(1));
}

void FarEnd::Tell(const RemoteReport& report) {
  if (gone_) return;
  reports_.Add(report);
  if (!reports_.Write()) gone_ = true;
}

void FarEnd::TellEnd(int status) {
  RemoteReport report;
  report.set_ended(status);
  Tell(report);
}

}  // namespace hgros::cli
