#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <typeinfo>
#include <vector>

#include "hgros/base/export.hpp"
#include "hgros/base/log.hpp"
#include "hgros/codec/raw_message.hpp"
#include "hgros/component/component.hpp"
#include "hgros/component/component_description.hpp"
#include "hgros/component/component_error.hpp"
#include "hgros/session/session.hpp"

namespace hgros {

/// One component of a robot.
struct ComponentSetup {
  std::string name;                                   ///< Its name in the robot, such as "mapper".
  std::string type;                                   ///< Of the registered ones, such as "slam2d/Mapper".
  std::map<std::string, std::string> remap = {};      ///< Its names of channels and services, and the robot's names.
  ParamSources params = {};                           ///< The values of its parameters.
  NodeOverrides nodes = {};                           ///< Queue and executor of its nodes, by their names within it.
  std::shared_ptr<const RawMessage> state = nullptr;  ///< What another instance has saved; null: it begins anew.
  Duration deadline{};                                ///< How long a callback may take; 0: as long as it wants.
};

enum class ComponentState : std::uint8_t {
  kWired,     ///< Constructed; no callback runs.
  kJoined,    ///< It receives messages and serves.
  kRunning,   ///< Its timers run, and it was activated.
  kFinished,  ///< It said Finish.
  kFailed,    ///< It said Fail, could not join, or Activate threw.
};
[[nodiscard]] HGROS_EXPORT std::string_view ToString(ComponentState state) noexcept;

struct ComponentStatus {
  std::string name;
  ComponentState state = ComponentState::kWired;
  std::string sentence = {};     ///< The result of Finish, or the reason of Fail.
  std::uint64_t exceptions = 0;  ///< Exceptions of its callbacks, handlers and timers.
  std::string exception = {};    ///< The text of the last one.
  std::uint64_t late = 0;        ///< Callbacks, handlers and timers that took longer than the deadline.
  /// It has called Context::transforms(), and its constructor has not, so ComponentDescription does not say so.
  bool undeclared_transforms = false;
};

struct ComponentsOptions {
  /// Gets each component's lines; empty: they go to the session's log, behind the component's name.
  std::function<void(std::string_view component, LogLevel level, std::string_view text)> log = {};
  /// Called after a status has changed, on the thread that changed it, which may be in a callback. It must not call
  /// Components.
  std::function<void(const ComponentStatus& status)> on_change = {};
  /// Called after parameters of a component have changed, except in its constructor, as ParamServer::OnChange says.
  std::function<void(std::string_view component, const ParamEvent& event)> on_params = {};
  /// Every callback runs in the thread that publishes, whatever its node and the configuration say. For tests.
  bool all_inline = false;
  /// Others can read and change the components' parameters.
  bool offer_params = true;
};

/// The components in one session.
///
///     hgros::Components components(session);
///     components.Add({.name = "mapper", .type = "slam2d/Mapper"});
///     components.Join();
///     components.Start();
///
/// A finished or failed component stays until End() or the destructor: its callbacks still run.
///
/// Threading: one thread at a time, outside callbacks of the session.
/// Lifetime:  ends before its session. Components end in reverse order of Add.
class HGROS_EXPORT Components {
 public:
  explicit Components(Session& session, ComponentsOptions options = {});
  Components(const Components&) = delete;
  Components& operator=(const Components&) = delete;
  ~Components();

  /// Constructs a component, and restores its state if there is one. If components were joined or started before, Join
  /// and Start must follow. Returns what it uses.
  ///
  /// Errors: throws Error if the name is taken, and ComponentError with all faults if the type is not registered, the
  /// constructor throws, the state cannot be restored, a parameter has a wrong value, or the setup has a remap, node or
  /// parameter that the component does not know (it names the nearest). Nothing is left of the component.
  const ComponentDescription& Add(const ComponentSetup& setup);
  /// The same with a type that need not be registered; ComponentSetup::type is not used.
  const ComponentDescription& Add(const ComponentType& type, ComponentSetup setup);
  /// Lets all wired components receive messages and serve. Throws Error if a channel has another type: that component
  /// has failed, and those behind it are still wired.
  void Join();
  /// Activates all joined components in the order of Add, each before its timers start. A component whose Activate
  /// throws has failed.
  void Start();

  /// Saves the state of a component between its callbacks, which wait meanwhile. Null if its class has no Save. Throws
  /// Error if callbacks still run after `patience`, or it has been deactivated.
  [[nodiscard]] std::shared_ptr<const RawMessage> Save(std::string_view name,
                                                       std::chrono::nanoseconds patience = std::chrono::seconds(1));
  using SetupAgain = std::function<ComponentSetup()>;
  using OnSaved = std::function<void(const std::shared_ptr<const RawMessage>& state)>;
  /// Constructs a component that runs again: lets its callbacks end, saves it, calls Deactivate, destroys it,
  /// constructs it from what `setup` returns, restores it, and lets it join and start. Its subscriptions stay, and what
  /// comes meanwhile waits for the new object, so no message is lost, handled twice or out of order. A call that waits
  /// fails and can be repeated. `saved` gets the state as soon as no callback runs. `setup` is called once the old
  /// object has gone, so it knows all changes of parameters; its ComponentSetup::state is not used.
  ///
  /// Errors: throws Error if the class has no Save, callbacks still run after `patience`, or it cannot be saved; it
  /// runs on then. Otherwise as Add and Join, or what `setup` and `saved` throw; what waits is lost then, and nothing
  /// is left of it.
  void ConstructAgain(std::string_view name, std::chrono::nanoseconds patience, const SetupAgain& setup,
                      const OnSaved& saved = {});
  /// Counts and logs callbacks that run for longer than the deadline and have not returned, each once. Those that have
  /// returned are counted without it.
  void NoteHanging(std::string_view name);
  /// Ends a component: its timers, Deactivate if it was activated, its subscriptions and services; then destroys it.
  void End(std::string_view name);
  /// The process is about to end: no more components are activated. Those that are still active 0.8 s later, because
  /// another one hangs or is slow, are deactivated together, each on a thread of its own; their timers stop before. The
  /// destructor calls this first. Call it earlier if the thread of the components may hang in one of them.
  /// Thread safety: from any thread.
  void BeginEnd() noexcept;

  [[nodiscard]] std::vector<ComponentStatus> statuses() const;
  [[nodiscard]] const ComponentDescription& description(std::string_view name) const;
  [[nodiscard]] ParamServer& params(std::string_view name) const;
  /// The object of that class, for tests. Null if there is no such component, or it is of another class.
  template <class C>
  [[nodiscard]] C* Find(std::string_view name) const {
    return static_cast<C*>(FindObject(name, typeid(C)));
  }
  [[nodiscard]] void* FindObject(std::string_view name, const std::type_info& type) const;

 private:
  friend class LeavingComponent;
  friend class ArrivingComponent;
  class Core;

  std::unique_ptr<Core> core_;
};

}  // namespace hgros
