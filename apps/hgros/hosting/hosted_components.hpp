#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "hgros/base/error.hpp"
#include "hgros/component/component_catalog.hpp"
#include "hgros/component/components.hpp"
#include "hgros/params/param_server.hpp"
#include "hgros/placement/robot_file.hpp"
#include "hosting/component_reports.hpp"
#include "hosting/restart_pauses.hpp"
#include "launch/kept_component.hpp"

namespace hgros::cli {

/// The components of one process: constructs them, tells the starter how they are, saves their states, and constructs
/// those again that have failed, if the robot file says so.
///
/// Threading: one thread, outside callbacks of the session. Note() and Keep() are called on others.
class HostedComponents {
 public:
  using Clock = std::chrono::steady_clock;

  /// Borrows all of them. `kept`: what earlier instances have left.
  HostedComponents(Session& session, ComponentReports& reports, const RobotFile& robot, const RobotProcess& process,
                   const KeptComponents& kept);

  /// Throws Error if one cannot be constructed.
  void Construct(const ComponentCatalog& catalog);
  void Join() { components_.Join(); }
  void Start();
  /// Does what is due: checkpoints and restarts. Returns when more is.
  [[nodiscard]] Clock::time_point Work();
  /// The last checkpoints, of those that have not failed. They are on the way when it returns.
  void SaveAll();
  /// Ends a component and constructs it again. One that can be saved goes on from its state, and what comes meanwhile
  /// waits for it, unless it has failed or finished or does not end its callbacks.
  void ConstructAgain(const std::string& name);

  // For ComponentMoves.
  [[nodiscard]] Components& components() noexcept { return components_; }
  [[nodiscard]] bool Runs(const std::string& name);
  /// A component will come from another place. Returns how to construct it.
  [[nodiscard]] ComponentSetup Expect(const RobotComponent& component, KeptComponent kept);
  /// Its new state, as a checkpoint.
  void Keep(const std::string& name, std::shared_ptr<const RawMessage> state) {
    hosted_.at(name).kept.state = std::move(state);
  }
  /// It runs here from now on.
  void Arrive(const std::string& name);
  /// While it moves, it is neither saved for checkpoints nor constructed again.
  void SetMoving(const std::string& name, bool moving);
  /// Takes over parameters that were changed in the other place since this one was constructed.
  void TakeParams(const std::string& name, const KeptComponent& there);
  /// It is none of this process any more, so nothing of it is told.
  void StopTelling(const std::string& name);
  /// The same. Ends it if it is still here.
  void Forget(const std::string& name);
  /// Constructs and starts one more.
  void Adopt(const std::string& name, KeptComponent kept);

  /// All have finished or failed.
  [[nodiscard]] bool AllEnded();
  [[nodiscard]] bool AnyFailed();

 private:
  struct Hosted {
    const RobotComponent* setup;
    KeptComponent kept{};
    Clock::time_point save_at = Clock::time_point::max();  // The next checkpoint.
    Clock::time_point look_at = Clock::time_point::max();  // For a callback that does not return.
    std::string saved{};                                   // The bytes of the last one.
    bool too_large = false;                                // Was said.
    std::string save_fault{};                              // Why it could not be saved: of the last line about it,
    Clock::time_point save_fault_again{};                  // which may come again then.
    bool moving = false;                                   // From or to another place.
    ComponentState state = ComponentState::kWired;         // Guarded by mutex_, as the rest.
    std::uint64_t exceptions = 0;                          // That have been handled.
    std::uint64_t late = 0;                                // Callbacks that have been handled.
    RestartPauses pauses{};
    bool undeclared = false;  // It was said that it has not declared transforms.
    bool given_up = false;    // It is not constructed again, because that was too often.
    bool ends = false;        // For that reason, and because its callbacks still throw.
    Clock::time_point restart_at = Clock::time_point::max();  // It is constructed again.
  };

  void Add(Hosted& one);
  // How its next instance is constructed.
  [[nodiscard]] ComponentSetup Next(const Hosted& one);
  static void Plan(Hosted& one);
  // Those that were changed, because of `error`.
  void ForgetParams(Hosted& one, const Error& error);
  void Save(Hosted& one);
  void SayNotSaved(Hosted& one, const std::string& why);
  void Keep(Hosted& one, const std::shared_ptr<const RawMessage>& state);
  void Restart(Hosted& one);
  void EndForGood(Hosted& one);
  void Forget(Hosted& one);
  // Whether it will be constructed again. mutex_ is held.
  [[nodiscard]] static bool PlanRestart(Hosted& one, const ComponentStatus& status);
  void Note(const ComponentStatus& status);
  void SayUndeclared(const std::string& name);
  void Keep(std::string_view component, const ParamEvent& event);
  [[nodiscard]] bool HasEnded(const Hosted& one) const;

  ComponentReports& reports_;
  const RobotFile& robot_;
  const RobotProcess& process_;
  const KeptComponents& kept_;
  bool started_ = false;

  std::mutex mutex_;
  std::map<std::string, Hosted, std::less<>> hosted_;
  Components components_;  // Ends first.
};

}  // namespace hgros::cli
