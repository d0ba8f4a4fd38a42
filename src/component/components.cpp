#include "hgros/component/components.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "component/components_core.hpp"
#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"
#include "hgros/base/readable_text.hpp"
#include "hgros/component/component_error.hpp"
#include "hgros/session/session_parts.hpp"

namespace hgros {

std::string_view ToString(ComponentState state) noexcept {
  switch (state) {
    case ComponentState::kWired: return "wired";
    case ComponentState::kJoined: return "joined";
    case ComponentState::kRunning: return "running";
    case ComponentState::kFinished: return "finished";
    case ComponentState::kFailed: return "failed";
  }
  return "unknown";
}

Components::Core::Core(Session& session, ComponentsOptions options)
    : session_(session),
      options_(std::move(options)),
      active_([this](std::string_view component, std::string_view warning) {
        if (options_.log) return options_.log(component, LogLevel::kWarning, warning);
        session_.log().Write(LogLevel::kWarning, std::string(component) + ": " + std::string(warning));
      }) {}

Components::Core::~Core() {
  active_.BeginEnd();
  while (!all_.empty()) all_.pop_back();
}

OneComponent& Components::Core::Add(const ComponentType* type, const ComponentSetup& setup, bool arrives) {
  if (const std::string fault = ChannelNameFault(setup.name); !fault.empty()) {
    throw Error("A component cannot be named \"" + Readable(setup.name, 64) + "\": " + fault + ".");
  }
  if (Find(setup.name) != nullptr) {
    throw Error("There are two components named \"" + setup.name + "\".", {}, "Give one another name.");
  }
  std::vector<Error> faults;
  try {
    auto one = std::make_unique<OneComponent>(
        ContextCore::Means{session_, options_, [this]() -> Transforms& { return SharedTransforms(); }}, active_,
        type == nullptr ? FindComponentType(setup.type) : *type, setup, arrives);
    faults = one->Construct();
    if (faults.empty() && setup.state) one->Restore(*setup.state);
    if (faults.empty()) return *all_.emplace_back(std::move(one));
  } catch (...) {
    faults.push_back(CurrentError(setup));
  }
  throw ComponentError(std::move(faults));
}

void Components::Core::Join() {
  for (const auto& one : all_) {
    if (!one->arrives && one->core.status().state == ComponentState::kWired) Join(*one);
  }
}

void Components::Core::Join(OneComponent& one) {
  try {
    one.core.Join();
    if (options_.offer_params) one.Offer(session_);
  } catch (...) {
    one.core.EndInputs();
    one.core.SetState(ComponentState::kFailed, "It could not join.");
    throw CurrentError(one.core.setup());
  }
}

void Components::Core::Start() {
  for (const auto& one : all_) {
    if (!one->arrives && one->core.status().state == ComponentState::kJoined) one->Start();
  }
}

void Components::Core::End(std::string_view name) {
  std::erase_if(all_, [&](const auto& one) { return one->core.setup().name == name; });
}

void Components::Core::ConstructAgain(std::string_view name, std::chrono::nanoseconds patience,
                                      const Components::SetupAgain& setup, const Components::OnSaved& saved) {
  OneComponent& one = Get(name);
  if (one.type.state == nullptr) {
    throw Error(Named(one.core.setup()) + "its class cannot be saved.", {}, "Give it Save() and Restore().");
  }
  const std::shared_ptr<const RawMessage> state = one.Save(patience, [&] {
    for (const auto& gate : one.core.gates()) gate->Hold([] {}, InputGate::Full::kWaits);
    one.core.SetPlace(ContextCore::Place::kHeld);
  });
  std::vector<Error> faults;
  try {
    if (saved) saved(state);  // At once: the end of the old object may hang.
    faults = one.ConstructAgain([&] {
      ComponentSetup next = setup();
      next.state = state;
      return next;
    });
    if (faults.empty()) one.Restore(*state);
  } catch (...) {
    faults.push_back(CurrentError(one.core.setup()));
  }
  if (!faults.empty()) {
    End(name);
    throw ComponentError(std::move(faults));
  }
  try {
    Join(one);
    one.Start();
  } catch (...) {
    End(name);
    throw;
  }
  one.core.EndUnused();
  one.core.SetPlace(ContextCore::Place::kHere);
  one.LetWaitingPass();
}

bool Components::Core::HasPublisherBeside(const OneComponent& one, std::string_view channel) const {
  const auto& outputs = one.core.description().outputs;
  if (std::ranges::find(outputs, channel, &ComponentChannel::channel) != outputs.end()) return false;  // Its own.
  return SessionParts(session_).IsPublished(channel);
}

std::vector<std::string> Components::Core::OwnOutputs(const OneComponent& one) const {
  const auto publishes_on = [](const OneComponent& other, const std::string& channel) {
    const auto& outputs = other.core.description().outputs;
    return std::ranges::find(outputs, channel, &ComponentChannel::channel) != outputs.end();
  };
  std::vector<std::string> own;
  for (const ComponentChannel& output : one.core.description().outputs) {
    const auto also = [&](const auto& other) { return other.get() != &one && publishes_on(*other, output.channel); };
    if (std::ranges::find(own, output.channel) == own.end() && std::ranges::none_of(all_, also)) {
      own.push_back(output.channel);
    }
  }
  return own;
}

OneComponent* Components::Core::Find(std::string_view name) {
  const auto found = std::ranges::find_if(all_, [&](const auto& one) { return one->core.setup().name == name; });
  return found == all_.end() ? nullptr : found->get();
}

OneComponent& Components::Core::Get(std::string_view name) {
  if (OneComponent* one = Find(name)) return *one;
  throw Error("There is no component named \"" + std::string(name) + "\" in this process.");
}

Transforms& Components::Core::SharedTransforms() {
  const std::scoped_lock lock(transforms_mutex_);
  if (!transforms_) transforms_.emplace(session_);
  return *transforms_;
}

Components::Components(Session& session, ComponentsOptions options)
    : core_(std::make_unique<Core>(session, std::move(options))) {}
Components::~Components() = default;

const ComponentDescription& Components::Add(const ComponentSetup& setup) {
  return core_->Add(nullptr, setup).core.description();
}
const ComponentDescription& Components::Add(const ComponentType& type, ComponentSetup setup) {
  setup.type = type.name;
  return core_->Add(&type, setup).core.description();
}
void Components::Join() { core_->Join(); }
void Components::Start() { core_->Start(); }
std::shared_ptr<const RawMessage> Components::Save(std::string_view name, std::chrono::nanoseconds patience) {
  return core_->Get(name).Save(patience);
}
void Components::ConstructAgain(std::string_view name, std::chrono::nanoseconds patience, const SetupAgain& setup,
                                const OnSaved& saved) {
  core_->ConstructAgain(name, patience, setup, saved);
}
void Components::NoteHanging(std::string_view name) { core_->Get(name).core.guard()->NoteHanging(); }
void Components::End(std::string_view name) { core_->End(name); }
void Components::BeginEnd() noexcept { core_->BeginEnd(); }

std::vector<ComponentStatus> Components::statuses() const {
  std::vector<ComponentStatus> statuses;
  for (const auto& one : core_->all()) statuses.push_back(one->core.status());
  return statuses;
}
const ComponentDescription& Components::description(std::string_view name) const {
  return core_->Get(name).core.description();
}
ParamServer& Components::params(std::string_view name) const { return core_->Get(name).core.params(); }
void* Components::FindObject(std::string_view name, const std::type_info& type) const {
  OneComponent* one = core_->Find(name);
  return one != nullptr && one->component->type() == type ? one->component->object() : nullptr;
}

}  // namespace hgros
