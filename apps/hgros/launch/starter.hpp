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
#include "launch/restart_pauses.hpp"
#include "launch/robot.pb.h"
#include "launch/robot_graph.hpp"
#include "launch/robot_log.hpp"
#include "launch/run.pb.h"
#include "launch/starter_clients.hpp"
#include "launch/unit_process.hpp"

namespace hgros::cli {

class RemoteUnits;

struct StarterOptions {
  std::string name;                       ///< Of the robot, for commands.
  bool json = false;                      ///< Everything as one JSON object per line.
  bool verbose = false;                   ///< Also lines of the level debug.
  std::function<void()> on_running = {};  ///< Called once everything runs.
  const RemoteUnits* remote = nullptr;    ///< Starts what runs on other hosts; null: all is started here. Borrowed.
};

/// Starts the processes and programs of a robot, shows their log, starts again what has failed, and ends them.
///
/// Threading: one thread, and no other in the process: it forks.
class Starter {
 public:
  /// Borrows all of them. Throws Error if a robot of that name runs.
  Starter(const RobotFile& robot, const RobotGraph& graph, const ComponentCatalog& catalog, Surroundings& surroundings,
          StarterOptions options);

  /// Until everything has ended, by itself or because the user ends the command. Returns the exit code: kFailed if
  /// something has failed.
  [[nodiscard]] int Run();

  // For commands.
  [[nodiscard]] std::vector<RobotReply::Unit> statuses() const;
  [[nodiscard]] const LogLines& lines() const noexcept { return log_.lines(); }
  /// The process or program of that name, or that of the component; empty: there is none.
  [[nodiscard]] std::string UnitOf(const std::string& name) const;
  /// Ends a process or program and starts it again. Returns how often it was started again before.
  std::uint64_t Restart(const std::string& unit);
  /// The same for a component alone. Returns how often it has begun to run; empty: its process does not run.
  std::optional<std::uint64_t> RestartAlone(const std::string& component);
  void Stop() { EndAll({}, code_); }

 private:
  using Clock = std::chrono::steady_clock;

  enum class Stage {
    kWaits,        // To be started.
    kBegun,        // Its process runs.
    kConstructed,  // A program is constructed at once.
    kJoined,
    kRunning,
    kEnds,   // Has been told to.
    kEnded,  // And is not started again.
  };
  struct Unit {
    const RobotUnit* setup;
    const RobotProcess* process = nullptr;  // Or a program.
    const RobotProgram* program = nullptr;
    Stage stage = Stage::kWaits;
    std::unique_ptr<UnitProcess> running{};
    int status = 0;  // Of its last end.
    std::uint64_t starts = 0;
    Clock::time_point started{};                           // The last time.
    Clock::time_point kill_at = Clock::time_point::max();  // It was told to end.
    std::string alone{};                                   // The component that is constructed again, as asked.
    bool again = false;                                    // Is to be started again when it has ended.
    Clock::time_point due{};                               // When it is started.
    RestartPauses restarts{};
    std::map<std::string, std::uint64_t> runs{};  // How often each component has begun to run.
    std::map<std::string, std::string> ended{};   // Components that ended by themselves: "failed" or "finished".
    bool failed = false;                          // A component of it, or its end.
    bool reported = false;                        // Its first failure.
  };

  void StartDue();
  void Start(Unit& unit);
  void Poll();
  void Hear(Unit& unit);
  void Take(Unit& unit, const RunReport& report);
  void TakeComponent(Unit& unit, const RunReport::Component& component);
  void TakeEnd(Unit& unit);
  void ReportFailure(Unit& unit, int status);
  void StartAgain(Unit& unit);
  void TellToEnd(Unit& unit);
  void KillLate();
  // Lets the units go on together: all join when all are constructed, and run when all have joined.
  void Advance();
  void SayWhatIsLate();
  void SendJoin(Unit& unit);
  static void Send(Unit& unit, const RunOrder& order);
  void Release(Unit& unit);

  // Everything ends, the last ones first. `why` is said; empty: the user knows.
  void EndAll(const std::string& why, int code);
  void EndNext();
  [[nodiscard]] bool AllEnded() const;
  [[nodiscard]] Clock::time_point NextDue() const;

  void Say(const Unit& unit, LogLevel level, const std::string& text);

  const RobotFile& robot_;
  const RobotGraph& graph_;
  const ComponentCatalog& catalog_;
  Surroundings& surroundings_;
  const StarterOptions options_;
  std::vector<Unit> units_;  // In the order of their start.
  StarterClients clients_;
  RobotLog log_;
  KeptComponents kept_;  // Of all processes.
  Clock::time_point late_at_;
  bool joining_ = false;   // All were told to join.
  bool released_ = false;  // All run.
  bool ending_ = false;
  bool at_once_ = false;  // The user has asked again.
  Clock::time_point kill_at_ = Clock::time_point::max();
  int code_ = kDone;
};

}  // namespace hgros::cli
