#include "component/one_component.hpp"

#include <exception>
#include <string_view>

#include "hgros/component/component_error.hpp"

namespace hgros {

std::string Named(const ComponentSetup& setup) {
  const std::string type = setup.type == setup.name ? "" : " (" + setup.type + ")";
  return "Component \"" + setup.name + "\"" + type + ": ";
}

namespace {

Error NamedError(const ComponentSetup& setup, const Error& error) {
  return Error(Named(setup) + error.sentence(), error.where(), error.mend());
}

std::string AllOf(const std::vector<Error>& faults) {
  std::string all;
  for (const Error& one : faults) all += (all.empty() ? "" : " ") + std::string(one.what());
  return all;
}

}  // namespace

ComponentError::ComponentError(std::vector<Error> faults) : Error(AllOf(faults)), faults_(std::move(faults)) {}

Error CurrentError(const ComponentSetup& setup) {
  try {
    throw;
  } catch (const Error& error) {
    return NamedError(setup, error);
  } catch (const std::exception& error) {
    return Error(Named(setup) + error.what());
  } catch (...) {
    return Error(Named(setup) + "it threw something that is no std::exception.");
  }
}

OneComponent::~OneComponent() {
  const ActiveComponents::Busy busy(active, core.setup().name);
  offered.reset();
  core.EndTimers();
  Deactivate();
  core.EndInputs();
}

std::vector<Error> OneComponent::Construct() {
  std::vector<Error> faults;
  core.transforms().SetConstructing(true);
  try {
    component = type.construct(core.context());
  } catch (...) {
    faults.push_back(CurrentError(core.setup()));
  }
  core.transforms().SetConstructing(false);
  const bool returned = component != nullptr;
  for (const Error& fault : core.EndConstruction(returned)) faults.push_back(NamedError(core.setup(), fault));
  return faults;
}

void OneComponent::Offer(Session& session) {
  if (core.description().params.empty()) return;
  offered.emplace(session, core.params(), core.setup().name,
                  [&log = core.log()](LogLevel level, std::string_view text) { log.Write(level, text); });
}

void OneComponent::Start() {
  if (!TryActivate()) return;
  try {
    core.StartTimers();
    core.SetState(ComponentState::kRunning);
  } catch (const std::exception& error) {
    core.EndBySelf(ComponentState::kFailed, error.what());
  }
}

void OneComponent::Activate() {
  const ActiveComponents::Busy busy(active, core.setup().name);
  deactivated = false;
  component->Activate();
  active.Add(*this);
}

bool OneComponent::TryActivate() {
  if (active.ends()) return false;
  try {
    Activate();
    return true;
  } catch (const std::exception& error) {
    core.EndBySelf(ComponentState::kFailed, error.what());
  } catch (...) {
    core.EndBySelf(ComponentState::kFailed, "Activate threw something that is no std::exception.");
  }
  return false;
}

void OneComponent::Deactivate() {
  const ActiveComponents::Busy busy(active, core.setup().name);
  if (active.Take(*this)) CallDeactivate();
}

void OneComponent::CallDeactivate() {
  deactivated = true;
  try {
    component->Deactivate();
  } catch (const std::exception& error) {
    core.log().Write(LogLevel::kError, "Its Deactivate threw: " + std::string(error.what()));
  } catch (...) {
    core.log().Write(LogLevel::kError, "Its Deactivate threw.");
  }
}

std::shared_ptr<const RawMessage> OneComponent::Save(std::chrono::nanoseconds patience,
                                                     const std::function<void()>& meanwhile) {
  if (type.state == nullptr) return nullptr;
  const ActiveComponents::Busy busy(active, core.setup().name);
  AnyMessage state;
  const auto save = [&] {
    if (deactivated) throw Error(Named(core.setup()) + "it has been deactivated already.");
    try {
      state = component->Save();
    } catch (...) {
      throw CurrentError(core.setup());
    }
    if (meanwhile) meanwhile();
  };
  const bool alone = core.guard()->TryAlone(std::chrono::steady_clock::now() + patience, save);
  if (!alone) throw Error(Named(core.setup()) + "it could not be saved: a callback of it has not returned.");
  Payload data = type.state->encode(state);
  if (data.owner == nullptr) {
    throw Error(Named(core.setup()) + "its state, a " + type.state->name + ", cannot be written.");
  }
  return std::make_shared<const RawMessage>(
      RawMessage{std::make_shared<const MessageSchema>(SchemaOf(*type.state)), std::move(data)});
}

void OneComponent::Restore(const RawMessage& state) {
  if (type.state == nullptr) {
    throw Error("It got the state of another instance, but its class has no Restore.", {},
                "Give it Save and Restore, or start it without a state.");
  }
  if (const std::string misfit = MisfitOf(*state.schema, *type.state); !misfit.empty()) {
    throw Error("Its state cannot be restored: " + misfit);
  }
  const AnyMessage read = type.state->decode(state.data);
  if (read == nullptr) throw Error("Its state cannot be restored: it is no " + type.state->name + ".");
  component->Restore(read);
}

std::vector<Error> OneComponent::ConstructAgain(const std::function<ComponentSetup()>& setup) {
  offered.reset();
  core.EndTimers();
  Deactivate();
  core.SetPlace(ContextCore::Place::kElsewhere);  // Calls that wait do not keep the end waiting.
  core.EndServices();
  core.SetPlace(ContextCore::Place::kHeld);
  component.reset();
  core.BeginAgain(setup());
  return Construct();
}

void OneComponent::LetWaitingPass() {
  for (const auto& gate : core.gates()) {
    gate->Pass([&](InputGate::Waiting waiting) { LetPass(*gate, std::move(waiting)); }, false);
  }
}

void OneComponent::LetPass(InputGate& gate, InputGate::Waiting waiting) {
  try {
    gate.LetPass(std::move(waiting));
  } catch (const std::exception& error) {
    core.log().Write(LogLevel::kError, "A callback of " + gate.node() + " threw: " + error.what());
  } catch (...) {
    core.log().Write(LogLevel::kError, "A callback of " + gate.node() + " threw.");
  }
}

}  // namespace hgros
