#include "hgros/component/components.hpp"

#include <algorithm>
#include <chrono>
#include <exception>
#include <mutex>
#include <optional>
#include <utility>

#include "component/context_core.hpp"
#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"
#include "hgros/params/param_service.hpp"
#include "hgros/tf/transforms.hpp"

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

namespace {

std::string Named(const ComponentSetup& setup) {
  const std::string type = setup.type == setup.name ? "" : " (" + setup.type + ")";
  return "Component \"" + setup.name + "\"" + type + ": ";
}

Error NamedError(const ComponentSetup& setup, const Error& error) {
  return Error(Named(setup) + error.sentence(), error.where(), error.mend());
}

// The error that is handled, with the component's name.
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

std::string AllOf(const std::vector<Error>& faults) {
  std::string all;
  for (const Error& one : faults) all += (all.empty() ? "" : " ") + std::string(one.what());
  return all;
}

}  // namespace

ComponentError::ComponentError(std::vector<Error> faults) : Error(AllOf(faults)), faults_(std::move(faults)) {}

class Components::Core {
 public:
  // Members end in reverse order: the object before what it uses.
  struct One {
    One(ContextCore::Means means, const ComponentType& its_type, const ComponentSetup& setup)
        : type(its_type), core(std::move(means), type, setup) {}
    One(const One&) = delete;
    One& operator=(const One&) = delete;
    ~One() {
      offered.reset();
      core.EndTimers();
      if (activated) Deactivate();
      core.EndInputs();
    }
    void Deactivate() {
      try {
        component->Deactivate();
      } catch (const std::exception& error) {
        core.log().Write(LogLevel::kError, "Its Deactivate threw: " + std::string(error.what()));
      } catch (...) {
        core.log().Write(LogLevel::kError, "Its Deactivate threw.");
      }
    }

    const ComponentType type;
    ContextCore core;
    std::unique_ptr<AnyComponent> component;
    std::optional<ParamService> offered;
    bool activated = false;
  };

  Core(Session& session, ComponentsOptions options) : session_(session), options_(std::move(options)) {}
  Core(const Core&) = delete;
  Core& operator=(const Core&) = delete;
  ~Core() {
    while (!all_.empty()) all_.pop_back();
  }

  // The registered type, if `type` is null.
  One& Add(const ComponentType* type, const ComponentSetup& setup) {
    if (const std::string fault = ChannelNameFault(setup.name); !fault.empty()) {
      throw Error("A component cannot be named \"" + setup.name + "\": " + fault + ".");
    }
    if (Find(setup.name) != nullptr) {
      throw Error("There are two components named \"" + setup.name + "\".", {}, "Give one another name.");
    }
    std::vector<Error> faults;
    try {
      auto one = std::make_unique<One>(
          ContextCore::Means{session_, options_, [this]() -> Transforms& { return SharedTransforms(); }},
          type == nullptr ? FindComponentType(setup.type) : *type, setup);
      faults = Construct(*one, setup);
      if (faults.empty() && setup.state) Restore(*one, *setup.state);
      if (faults.empty()) return *all_.emplace_back(std::move(one));
    } catch (...) {
      faults.push_back(CurrentError(setup));
    }
    throw ComponentError(std::move(faults));
  }

  void Join() {
    for (const auto& one : all_) {
      if (one->core.status().state != ComponentState::kWired) continue;
      try {
        one->core.Join();
        if (options_.offer_params && !one->core.description().params.empty()) {
          one->offered.emplace(session_, one->core.params(), one->core.setup().name);
        }
      } catch (...) {
        one->core.EndInputs();
        one->core.SetState(ComponentState::kFailed, "It could not join.");
        throw CurrentError(one->core.setup());
      }
    }
  }

  void Start() {
    for (const auto& one : all_) {
      if (one->core.status().state != ComponentState::kJoined) continue;
      try {
        one->component->Activate();
        one->activated = true;
        one->core.StartTimers();
        one->core.SetState(ComponentState::kRunning);
      } catch (const std::exception& error) {
        one->core.EndBySelf(ComponentState::kFailed, error.what());
      } catch (...) {
        one->core.EndBySelf(ComponentState::kFailed, "Activate threw something that is no std::exception.");
      }
    }
  }

  std::shared_ptr<const RawMessage> Save(One& one, std::chrono::nanoseconds patience) {
    if (one.type.state == nullptr) return nullptr;
    AnyMessage state;
    const auto save = [&] {
      try {
        state = one.component->Save();
      } catch (...) {
        throw CurrentError(one.core.setup());
      }
    };
    if (!one.core.guard()->TryAlone(std::chrono::steady_clock::now() + patience, save)) {
      throw Error(Named(one.core.setup()) + "it could not be saved: a callback of it has not returned.");
    }
    const TypeInfo& type = *one.type.state;
    Payload data = type.encode(state);
    if (data.owner == nullptr) {
      throw Error(Named(one.core.setup()) + "its state, a " + type.name + ", cannot be written.");
    }
    return std::make_shared<const RawMessage>(
        RawMessage{std::make_shared<const MessageSchema>(SchemaOf(type)), std::move(data)});
  }

  void End(std::string_view name) {
    std::erase_if(all_, [&](const auto& one) { return one->core.setup().name == name; });
  }

  One* Find(std::string_view name) {
    const auto found = std::ranges::find_if(all_, [&](const auto& one) { return one->core.setup().name == name; });
    return found == all_.end() ? nullptr : found->get();
  }
  One& Get(std::string_view name) {
    if (One* one = Find(name)) return *one;
    throw Error("There is no component named \"" + std::string(name) + "\" in this process.");
  }
  [[nodiscard]] const std::vector<std::unique_ptr<One>>& all() const noexcept { return all_; }

 private:
  // Returns all faults.
  static std::vector<Error> Construct(One& one, const ComponentSetup& setup) {
    std::vector<Error> faults;
    try {
      one.component = one.type.construct(one.core.context());
    } catch (...) {
      faults.push_back(CurrentError(setup));
    }
    const bool returned = one.component != nullptr;
    for (const Error& fault : one.core.EndConstruction(returned)) faults.push_back(NamedError(setup, fault));
    return faults;
  }

  static void Restore(One& one, const RawMessage& state) {
    if (one.type.state == nullptr) {
      throw Error("It got the state of another instance, but its class has no Restore.", {},
                  "Give it Save and Restore, or start it without a state.");
    }
    if (const std::string misfit = MisfitOf(*state.schema, *one.type.state); !misfit.empty()) {
      throw Error("Its state cannot be restored: " + misfit);
    }
    const AnyMessage read = one.type.state->decode(state.data);
    if (read == nullptr) throw Error("Its state cannot be restored: it is no " + one.type.state->name + ".");
    one.component->Restore(read);
  }

  Transforms& SharedTransforms() {
    const std::scoped_lock lock(transforms_mutex_);
    if (!transforms_) transforms_.emplace(session_);
    return *transforms_;
  }

  Session& session_;
  const ComponentsOptions options_;
  std::mutex transforms_mutex_;
  std::optional<Transforms> transforms_;
  std::vector<std::unique_ptr<One>> all_;
};

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
  return core_->Save(core_->Get(name), patience);
}
void Components::End(std::string_view name) { core_->End(name); }

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
  Core::One* one = core_->Find(name);
  return one != nullptr && one->component->type() == type ? one->component->object() : nullptr;
}

}  // namespace hgros
