#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "component/component_guard.hpp"
#include "component/input_gates.hpp"
#include "component/own_transforms.hpp"
#include "hgros/component/component_description.hpp"
#include "hgros/component/components.hpp"
#include "hgros/component/context.hpp"
#include "hgros/params/param_error.hpp"
#include "hgros/params/param_server.hpp"

namespace hgros {

// Behind a Context: the wiring of one component, which waits until its stage has come.
//
// Thread safety: the functions that Context calls. The others are for Components, on one thread.
class ContextCore {
 public:
  struct Means {
    Session& session;
    const ComponentsOptions& options;
    std::function<Transforms&()> transforms;  // Those that all components share.
  };
  ContextCore(Means means, const ComponentType& type, ComponentSetup setup);
  ContextCore(const ContextCore&) = delete;
  ContextCore& operator=(const ContextCore&) = delete;

  [[nodiscard]] Context& context() noexcept { return context_; }
  [[nodiscard]] const ComponentSetup& setup() const noexcept { return setup_; }
  [[nodiscard]] const ComponentDescription& description() const noexcept { return description_; }
  [[nodiscard]] ComponentStatus status() const;

  // Returns wrong values of parameters, and if the constructor has returned, what the setup names and the component
  // does not have.
  [[nodiscard]] std::vector<Error> EndConstruction(bool returned);
  // The inputs and services.
  void Join();
  void JoinInputs();
  void JoinServices();
  // The timers. Does nothing once the component has ended by itself.
  void StartTimers();
  void SetState(ComponentState state, std::string sentence = {});
  void EndTimers();
  // Ends inputs and services.
  void EndInputs();
  void EndServices();

  // Another instance follows one that has gone, with its services and timers, while it was held. Inputs stay wired if
  // this instance asks for the same; EndUnused() ends the others.
  void BeginAgain(ComponentSetup setup);
  void EndUnused();

  // For moves. Those of a component that can be saved.
  [[nodiscard]] std::vector<std::shared_ptr<InputGate>> gates() const { return gates_.all(); }
  enum class Place { kHere, kHeld, kElsewhere };
  // Calls and ticks of timers wait while the component is held. Elsewhere calls fail and ticks are skipped.
  void SetPlace(Place place);

  // For Context.
  [[nodiscard]] Session& session() const noexcept { return means_.session; }
  [[nodiscard]] const std::shared_ptr<ComponentGuard>& guard() const noexcept { return guard_; }
  [[nodiscard]] ParamServer& params() noexcept { return *params_; }
  [[nodiscard]] Log& log() noexcept { return log_; }
  [[nodiscard]] OwnTransforms& transforms() noexcept { return transforms_; }
  [[nodiscard]] Transforms& UseTransforms();
  // Keeps what is wrong with a parameter for EndConstruction(). False if the constructor has returned.
  [[nodiscard]] bool NoteFault(std::string_view param, const ParamError& fault);
  [[nodiscard]] std::string NameHere(std::string_view name);
  [[nodiscard]] std::string AddOutput(std::string_view channel, const std::string& type, std::uint64_t fingerprint);
  [[nodiscard]] std::string AddCalled(std::string_view service, const TypeInfo& request, const TypeInfo& reply);
  void AddInput(const ComponentInput& input, AnyCallback callback, NodeOptions options);
  void AddService(const ServedByComponent& served, AnyHandler handler, NodeOptions options);
  void AddTimer(std::string_view timer, Duration period, TimerCallback callback, NodeTimerOptions options);
  // Only the first one counts.
  void EndBySelf(ComponentState state, std::string sentence);

 private:
  using Kept = std::shared_ptr<const void>;
  struct Wire {
    std::string node;
    std::function<Kept()> make;
  };
  // What waits for a stage, or exists since.
  struct Stage {
    bool begun = false;
    bool ended = false;
    int in_progress = 0;  // Wires that are called now.
    std::vector<Wire> waiting{};
    std::vector<std::pair<std::string, Kept>> kept{};  // By node.
  };

  void Add(Stage& stage, Wire wire);
  void EndInput(InputGate& gate);
  void Begin(Stage& stage);
  void End(Stage& stage);
  // Makes the node's name unique, puts the component's before it, and returns what the setup says of the node.
  [[nodiscard]] NodeOverride SetUpNode(std::string_view channel, std::string& name);
  void SetUp(std::string_view channel, NodeOptions& options);
  // Waits while the component is held. Throws Error if it has gone.
  void AwaitHere();
  void NoteException(const std::string& what);
  void NoteLate(const std::string& sentence);
  void Report() const;
  [[nodiscard]] LogSink Sink() const;
  [[nodiscard]] static ParamSources SourcesOf(const ComponentSetup& setup);

  const Means means_;
  ComponentSetup setup_;
  std::optional<ParamServer> params_;
  Listening changes_;  // Of params_, once it is constructed.
  Log log_;
  const std::shared_ptr<ComponentGuard> guard_;
  OwnTransforms transforms_;
  Context context_;

  mutable std::mutex report_mutex_;
  mutable std::mutex mutex_;
  std::condition_variable wired_;
  std::condition_variable placed_;
  std::atomic<Place> place_ = Place::kHere;  // Set under mutex_.
  InputGates gates_;
  ComponentStatus status_;
  ComponentDescription description_;  // Changes only while an instance is constructed.
  bool constructed_ = false;
  std::set<std::string> names_;  // Channels and services that the component has named.
  std::set<std::string> nodes_;  // Names of its nodes, within the component.
  std::map<std::string, Error> faulty_params_;
  Stage inputs_;
  Stage services_;
  Stage timers_;
};

}  // namespace hgros
