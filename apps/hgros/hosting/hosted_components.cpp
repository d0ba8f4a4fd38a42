#include "hosting/hosted_components.hpp"

#include <algorithm>
#include <utility>

#include "hgros/base/bytes.hpp"
#include "hgros/tf/transforms.hpp"

namespace hgros::cli {
namespace {

constexpr std::chrono::milliseconds kSavePatience{200};
constexpr std::chrono::seconds kBetweenEqualFaults{10};
constexpr std::chrono::seconds kRestartPatience{3};        // Of 5 s that the starter waits for the next instance.
constexpr Duration kRarestLook = std::chrono::seconds(1);  // A callback that returns needs none.

bool IsOver(ComponentState state) { return state == ComponentState::kFinished || state == ComponentState::kFailed; }

}  // namespace

HostedComponents::HostedComponents(Session& session, ComponentReports& reports, const RobotFile& robot,
                                   const RobotProcess& process, const KeptComponents& kept)
    : reports_(reports),
      robot_(robot),
      process_(process),
      kept_(kept),
      components_(session, {.log = [this](std::string_view component, LogLevel level,
                                          std::string_view text) { reports_.Line(component, level, text); },
                            .on_change = [this](const ComponentStatus& status) { Note(status); },
                            .on_params = [this](std::string_view component,
                                                const ParamEvent& event) { Keep(component, event); }}) {}

void HostedComponents::Construct(const ComponentCatalog& catalog) {
  for (const std::string& name : process_.components) {
    const RobotComponent& component = *robot_.FindComponent(name);
    (void)catalog.Load(component.setup.type);
    Hosted* one = nullptr;
    {
      const std::scoped_lock lock(mutex_);
      one = &hosted_.emplace(name, Hosted{&component}).first->second;
    }
    if (const auto kept = kept_.find(name); kept != kept_.end()) one->kept = kept->second;
    Add(*one);
  }
}

void HostedComponents::Add(Hosted& one) {
  try {
    (void)components_.Add(Next(one));
  } catch (const Error& error) {
    if (one.kept.params.empty()) throw;
    ForgetParams(one, error);
    (void)components_.Add(Next(one));
  }
}

ComponentSetup HostedComponents::Next(const Hosted& one) {
  const std::scoped_lock lock(mutex_);
  return one.kept.Continue(one.setup->setup);
}

void HostedComponents::ForgetParams(Hosted& one, const Error& error) {
  std::string all;
  for (const auto& [path, value] : one.kept.params) all += (all.empty() ? "" : ", ") + path + ": " + value;
  reports_.Line(one.setup->setup.name, LogLevel::kWarning,
                "It cannot be constructed with the parameters that were changed while it ran (" + all +
                    "), so it begins without them. " + error.what());
  one.kept.params.clear();
  RunReport report;
  report.mutable_changed()->set_component(one.setup->setup.name);
  reports_.Tell(report);
}

void HostedComponents::Start() {
  components_.Start();
  started_ = true;
  for (auto& [name, one] : hosted_) {
    Plan(one);
  }
}

// Its first checkpoint, and the first look at its callbacks.
void HostedComponents::Plan(Hosted& one) {
  const Clock::time_point now = Clock::now();
  if (one.setup->checkpoint.count() > 0) one.save_at = now + one.setup->checkpoint;
  if (one.setup->setup.deadline.count() > 0) one.look_at = now + std::max(one.setup->setup.deadline, kRarestLook);
}

HostedComponents::Clock::time_point HostedComponents::Work() {
  Clock::time_point due = Clock::time_point::max();
  for (auto& [name, one] : hosted_) {
    if (one.moving) continue;
    bool restarts = false;
    bool ends = false;
    {
      const std::scoped_lock lock(mutex_);
      restarts = one.restart_at <= Clock::now();
      ends = one.ends;
    }
    if (restarts) Restart(one);
    if (ends) EndForGood(one);
    if (one.save_at <= Clock::now()) {
      Save(one);
      one.save_at = std::max(one.save_at + one.setup->checkpoint, Clock::now());
    }
    if (one.look_at <= Clock::now()) {
      components_.NoteHanging(name);
      one.look_at = Clock::now() + std::max(one.setup->setup.deadline, kRarestLook);
    }
    const std::scoped_lock lock(mutex_);
    due = std::min({due, one.save_at, one.restart_at, one.look_at});
  }
  return due;
}

// --- checkpoints ---

void HostedComponents::SaveAll() {
  RunReport saving;
  saving.set_stage(RunReport::SAVING);
  for (auto& [name, one] : hosted_) {
    if (one.save_at == Clock::time_point::max()) continue;
    reports_.Tell(saving);
    reports_.Flush();  // For a state on the way.
    Save(one);
  }
  reports_.Flush();  // What comes next may hang.
}

void HostedComponents::Save(Hosted& one) {
  const std::string& name = one.setup->setup.name;
  {
    const std::scoped_lock lock(mutex_);
    if (one.state == ComponentState::kFailed || one.restart_at != Clock::time_point::max()) return;
  }
  if (reports_.full()) return;  // The starter does not read.
  std::shared_ptr<const RawMessage> state;
  try {
    state = components_.Save(name, kSavePatience);
  } catch (const std::exception& error) {
    return SayNotSaved(one, error.what());
  }
  one.save_fault.clear();
  if (state != nullptr) Keep(one, state);
}

// A Save() that fails each time would fill the log.
void HostedComponents::SayNotSaved(Hosted& one, const std::string& why) {
  const auto now = Clock::now();
  if (one.save_fault == why && now < one.save_fault_again) return;
  one.save_fault = why;
  one.save_fault_again = now + kBetweenEqualFaults;
  reports_.Line(one.setup->setup.name, LogLevel::kWarning, "There is no new checkpoint: " + why);
}

void HostedComponents::Keep(Hosted& one, const std::shared_ptr<const RawMessage>& state) {
  const std::string& name = one.setup->setup.name;
  if (AsText(state->data.bytes) == one.saved) return;
  if (state->data.bytes.size() > kMostStateBytes) {
    if (!std::exchange(one.too_large, true)) {
      reports_.Line(name, LogLevel::kWarning,
                    "There is no new checkpoint: its state has " + std::to_string(state->data.bytes.size()) +
                        " bytes, and the most are " + std::to_string(kMostStateBytes) + ".");
    }
    return;
  }
  one.saved = AsText(state->data.bytes);
  one.kept.state = state;
  reports_.Tell(ReportOf(name, *state));
}

void HostedComponents::Keep(std::string_view component, const ParamEvent& event) {
  for (const ParamPath& path : event.paths) {
    const ParamView after = event.after.At(path);
    RunReport report;
    RunReport::Changed& changed = *report.mutable_changed();
    changed.set_component(std::string(component));
    changed.set_path(path.ToString());
    if (after.exists()) changed.set_value(after.ToYaml());
    {
      const std::scoped_lock lock(mutex_);
      const auto found = hosted_.find(component);
      if (found == hosted_.end()) return;
      found->second.kept.params[changed.path()] = changed.value();
    }
    reports_.Tell(report);
  }
}

// --- restarts ---

bool HostedComponents::PlanRestart(Hosted& one, const ComponentStatus& status) {
  const bool threw = status.exceptions > one.exceptions;
  const bool late = status.late > one.late;
  one.exceptions = status.exceptions;
  one.late = status.late;
  const ComponentRestart policy = one.setup->restart;
  const bool wanted = (status.state == ComponentState::kFailed && policy != ComponentRestart::kNever) ||
                      (threw && policy >= ComponentRestart::kOnException) ||
                      (late && policy == ComponentRestart::kOnDeadline);
  if (!wanted || one.given_up || one.restart_at != Clock::time_point::max()) return false;
  const std::optional<std::chrono::milliseconds> pause = one.pauses.Next(Clock::now());
  one.given_up = !pause;
  one.ends = !pause && threw && status.state != ComponentState::kFailed;
  if (!pause) return false;
  one.restart_at = Clock::now() + *pause;
  return true;
}

// Between hosts pass the channels that constructors have declared.
void HostedComponents::SayUndeclared(const std::string& name) {
  const auto passes = [](const auto& endpoints) {
    return std::ranges::any_of(endpoints, [](const EndpointConfig& one) {
      return one.all_channels || std::ranges::binary_search(one.channels, kTransformsChannel);
    });
  };
  if (robot_.hosts.size() < 2 || passes(process_.config.publishers) || passes(process_.config.subscribers)) return;
  reports_.Line(
      name, LogLevel::kWarning,
      "It uses transforms, but its constructor did not ask for them, so they do not pass between the hosts of "
      "the robot. Take them from the context in the constructor, and keep them.");
}

void HostedComponents::Note(const ComponentStatus& status) {
  RunReport report;
  RunReport::Component& component = *report.mutable_component();
  component.set_name(status.name);
  component.set_state(static_cast<int>(status.state));
  component.set_sentence(status.sentence);
  component.set_exceptions(status.exceptions);
  bool given_up = false;
  bool undeclared = false;
  {
    const std::scoped_lock lock(mutex_);
    const auto found = hosted_.find(status.name);
    if (found == hosted_.end()) return;
    Hosted& one = found->second;
    const bool planned = one.restart_at != Clock::time_point::max();
    if (planned && IsOver(status.state)) return;  // Of an instance that ends.
    undeclared = status.undeclared_transforms && !std::exchange(one.undeclared, true);
    component.set_changed(std::exchange(one.state, status.state) != status.state);
    const std::string why = status.late > one.late ? "A callback took longer than its deadline." : status.exception;
    const bool said = one.given_up;
    component.set_again(PlanRestart(one, status));
    if (component.again() && status.state != ComponentState::kFailed) component.set_sentence(why);
    given_up = one.given_up && !said;
  }
  if (undeclared) SayUndeclared(status.name);
  if (given_up) {
    reports_.Line(
        status.name, LogLevel::kError,
        "It was constructed again " + std::to_string(RestartPauses::kMost) + " times within a minute, and now is not.");
  }
  reports_.Tell(report);
  reports_.Wake();
}

void HostedComponents::ConstructAgain(const std::string& name) {
  const auto found = hosted_.find(name);
  if (found == hosted_.end() || found->second.moving) return;
  Hosted& one = found->second;
  if (!Runs(name) || components_.description(name).state.empty()) {
    if (one.save_at != Clock::time_point::max()) Save(one);
    return Restart(one);
  }
  try {
    components_.ConstructAgain(
        name, kRestartPatience,
        [&] {
          Forget(one);
          return Next(one);
        },
        [&](const auto& state) { Keep(one, state); });
  } catch (const std::exception& error) {
    reports_.Line(name, LogLevel::kWarning,
                  std::string("It ends first, so the messages that wait for it are lost. ") + error.what());
    Restart(one);
  }
}

// What was noted of the last instance.
void HostedComponents::Forget(Hosted& one) {
  const std::scoped_lock lock(mutex_);
  one.state = ComponentState::kWired;
  one.exceptions = one.late = 0;
  one.restart_at = Clock::time_point::max();
  one.given_up = one.ends = false;
}

// A callback that throws each time would fill the log.
void HostedComponents::EndForGood(Hosted& one) {
  const std::string& name = one.setup->setup.name;
  components_.End(name);
  one.save_at = one.look_at = Clock::time_point::max();
  {
    const std::scoped_lock lock(mutex_);
    one.ends = false;
  }
  Note({name, ComponentState::kFailed, "Its callbacks still throw exceptions."});
}

void HostedComponents::Restart(Hosted& one) {
  const std::string& name = one.setup->setup.name;
  components_.End(name);
  Forget(one);
  one.save_at = one.look_at = Clock::time_point::max();
  try {
    Add(one);
    components_.Join();
    if (!started_) return;
    components_.Start();
    Plan(one);
  } catch (const std::exception& error) {
    reports_.Line(name, LogLevel::kError, error.what());
    Note({name, ComponentState::kFailed, "It could not be constructed again."});
  }
}

// --- moves ---

bool HostedComponents::Runs(const std::string& name) {
  const std::scoped_lock lock(mutex_);
  const auto found = hosted_.find(name);
  return found != hosted_.end() && found->second.state == ComponentState::kRunning &&
         found->second.restart_at == Clock::time_point::max();
}

ComponentSetup HostedComponents::Expect(const RobotComponent& component, KeptComponent kept) {
  const std::scoped_lock lock(mutex_);
  Hosted& one = hosted_.insert_or_assign(component.setup.name, Hosted{&component}).first->second;
  one.kept = std::move(kept);
  one.moving = true;
  return one.kept.Continue(component.setup);
}

void HostedComponents::Arrive(const std::string& name) { Plan(hosted_.at(name)); }

void HostedComponents::TakeParams(const std::string& name, const KeptComponent& there) {
  const std::vector<ParamChange> changes = [&] {
    const std::scoped_lock lock(mutex_);
    return there.ChangesSince(hosted_.at(name).kept);
  }();
  if (changes.empty()) return;
  const ParamResult result = components_.params(name).Change(changes);
  if (result.ok()) return;
  reports_.Line(name, LogLevel::kWarning,
                "A parameter that was changed while it moved has its earlier value again. " + result.refusal);
}

void HostedComponents::SetMoving(const std::string& name, bool moving) {
  if (const auto found = hosted_.find(name); found != hosted_.end()) found->second.moving = moving;
}

void HostedComponents::StopTelling(const std::string& name) {
  const std::scoped_lock lock(mutex_);
  hosted_.erase(name);
}

void HostedComponents::Forget(const std::string& name) {
  StopTelling(name);
  components_.End(name);
}

void HostedComponents::Adopt(const std::string& name, KeptComponent kept) {
  (void)Expect(*robot_.FindComponent(name), std::move(kept));
  Hosted& one = hosted_.at(name);
  one.moving = false;
  Plan(one);
  Restart(one);
}

bool HostedComponents::HasEnded(const Hosted& one) const {
  return IsOver(one.state) && one.restart_at == Clock::time_point::max() && !one.moving;
}

bool HostedComponents::AllEnded() {
  const std::scoped_lock lock(mutex_);
  return !hosted_.empty() && std::ranges::all_of(hosted_, [this](const auto& one) { return HasEnded(one.second); });
}

bool HostedComponents::AnyFailed() {
  const std::scoped_lock lock(mutex_);
  return std::ranges::any_of(
      hosted_, [this](const auto& one) { return HasEnded(one.second) && one.second.state == ComponentState::kFailed; });
}

}  // namespace hgros::cli
