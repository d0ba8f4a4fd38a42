#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "component/active_components.hpp"
#include "component/context_core.hpp"
#include "hgros/base/error.hpp"
#include "hgros/codec/raw_message.hpp"
#include "hgros/component/component.hpp"
#include "hgros/params/param_service.hpp"

namespace hgros {

// "Component "mapper" (slam2d/Mapper): ", before errors.
[[nodiscard]] std::string Named(const ComponentSetup& setup);

// In a catch block: the exception, with the component's name before it.
[[nodiscard]] Error CurrentError(const ComponentSetup& setup);

// One of the components in a session.
//
// Threading: as Components.
struct OneComponent {
  // `from_elsewhere`: it arrives from another place.
  OneComponent(ContextCore::Means means, ActiveComponents& all_active, const ComponentType& its_type,
               const ComponentSetup& setup, bool from_elsewhere = false)
      : type(its_type), active(all_active), core(std::move(means), type, setup), arrives(from_elsewhere) {
    if (arrives) (void)core.transforms().Withhold();
  }
  OneComponent(const OneComponent&) = delete;
  OneComponent& operator=(const OneComponent&) = delete;
  ~OneComponent();

  // Returns all faults.
  [[nodiscard]] std::vector<Error> Construct();
  // Its parameters, for others.
  void Offer(Session& session);
  // With its timers.
  void Start();
  // A component whose Activate throws has failed; false then, and if the process ends.
  bool TryActivate();
  // Throws what that throws.
  void Activate();
  // If it is active. Another thread may be doing so; then this waits.
  void Deactivate();
  void CallDeactivate();
  // Null if its class has no Save. `meanwhile` runs while no callback can begin. Throws Error if callbacks still run
  // after `patience`.
  [[nodiscard]] std::shared_ptr<const RawMessage> Save(std::chrono::nanoseconds patience,
                                                       const std::function<void()>& meanwhile = {});
  void Restore(const RawMessage& state);
  // The object ends while it is held, and another one is constructed. Returns all faults.
  [[nodiscard]] std::vector<Error> ConstructAgain(const std::function<ComponentSetup()>& setup);
  // Messages that wait pass, then those that come.
  void LetWaitingPass();
  // As InputGate::LetPass. Logs what the callback throws.
  void LetPass(InputGate& gate, InputGate::Waiting waiting);

  // They end in reverse order: the object before what it uses.
  const ComponentType type;
  ActiveComponents& active;
  ContextCore core;
  std::unique_ptr<AnyComponent> component;
  std::optional<ParamService> offered;
  std::atomic<bool> deactivated{false};  // And not activated again: its state may be gone.
  bool arrives;                          // From another place: Join and Start of Components leave it alone.
};

}  // namespace hgros
