#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "arguments/command.hpp"
#include "hgros/component/component_catalog.hpp"
#include "hgros/placement/robot_file.hpp"
#include "launch/kept_component.hpp"
#include "launch/mover.hpp"
#include "launch/robot.pb.h"
#include "launch/robot_graph.hpp"
#include "launch/robot_log.hpp"
#include "launch/run.pb.h"
#include "launch/started_unit.hpp"
#include "launch/starter_clients.hpp"

namespace hgros::cli {

class RemoteUnits;

struct StarterOptions {
  std::string name;                       ///< Of the robot, for commands.
  bool json = false;                      ///< Everything as one JSON object per line.
  bool verbose = false;                   ///< Also lines of the level debug.
  bool keeps_report = false;              ///< Leaves a report for commands when everything has ended.
  std::function<void()> on_running = {};  ///< Called once everything runs.
  const RemoteUnits* remote = nullptr;    ///< Starts what runs on other hosts; null: all is started here. Borrowed.
  /// Called when a component runs in another process from now on. `graph` and `remote` must see it.
  std::function<void(const std::string& component, const std::string& process)> on_placed = {};
};

/// Starts the processes and programs of a robot, shows their log, starts again what has failed, and ends them.
///
/// Threading: one thread, and no other in the process: it forks.
class Starter {
 public:
  /// Borrows what it gets as a reference. Throws Error if a robot of that name runs.
  Starter(RobotFile robot, const RobotGraph& graph, const ComponentCatalog& catalog, Surroundings& surroundings,
          StarterOptions options);

  /// Until everything has ended, by itself or because the user ends the command. Returns the exit code: kFailed if
  /// something has failed.
  [[nodiscard]] int Run();

  // For commands.
  [[nodiscard]] std::vector<RobotReply::Unit> statuses() const;
  [[nodiscard]] const LogLines& lines() const noexcept { return log_.lines(); }
  /// The process or program of that name, or that of the component; empty: there is none.
  [[nodiscard]] std::string UnitOf(const std::string& name) const;
  /// Whether all have been started. Until then nothing is started again.
  [[nodiscard]] bool released() const noexcept { return released_; }
  [[nodiscard]] bool ending() const noexcept { return ending_; }
  /// Whether this process is about to be started again, or its components begin to run.
  [[nodiscard]] bool Starts(const std::string& unit) const;
  /// Ends a process or program and starts it again. Returns how often it was started again before.
  std::uint64_t Restart(const std::string& unit);
  /// The same for a component alone. Returns how often it has begun to run; empty: its process does not run.
  std::optional<std::uint64_t> RestartAlone(const std::string& component);
  /// Moves a component; mover() tells what became of it.
  void Move(const std::string& component, const std::string& to);
  [[nodiscard]] const Mover& mover() const noexcept { return mover_; }
  void Stop() { EndAll({}, code_); }

 private:
  using Clock = std::chrono::steady_clock;
  using Unit = StartedUnit;
  using Stage = UnitStage;

  void StartDue();
  void Start(Unit& unit);
  void Poll();
  void Hear(Unit& unit);
  void Take(Unit& unit, const RunReport& report);
  void TakeComponent(Unit& unit, const RunReport::Component& component);
  void TakeEnd(Unit& unit);
  void TakeStatus(Unit& unit);
  void ReportFailure(Unit& unit, int status);
  void StartAgain(Unit& unit);
  void KillLate();
  // Lets the units go on together: all join when all are constructed, and run when all have joined.
  void Advance();
  void SayWhatIsLate();

  // Everything ends, the last ones first. `why` is said; empty: the user knows.
  void EndAll(const std::string& why, int code);
  void EndNext();
  // Processes that components have left end when nothing else runs.
  void EndEmpty();
  [[nodiscard]] bool AllEnded() const;
  [[nodiscard]] Clock::time_point NextDue() const;

  void Say(const Unit& unit, LogLevel level, const std::string& text);

  OrphanGuard guard_;  // First, while little is to be copied.
  RobotFile robot_;    // Components may move.
  const RobotGraph& graph_;
  const ComponentCatalog& catalog_;
  Surroundings& surroundings_;
  StarterOptions options_;
  std::vector<Unit> units_;  // In the order of their start.
  StarterClients clients_;
  RobotLog log_;
  KeptComponents kept_;  // Of all processes.
  Mover mover_;
  Clock::time_point late_at_;
  bool joining_ = false;   // All were told to join.
  bool released_ = false;  // All run.
  bool ending_ = false;
  bool at_once_ = false;  // The user has asked again.
  Clock::time_point together_at_ = Clock::time_point::max();
  Clock::time_point kill_at_ = Clock::time_point::max();
  int code_ = kDone;
};

}  // namespace hgros::cli
