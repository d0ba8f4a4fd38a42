#pragma once

#include <poll.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "hgros/placement/robot_file.hpp"
#include "hosting/restart_pauses.hpp"
#include "launch/robot_graph.hpp"
#include "launch/run.pb.h"
#include "processes/unit_process.hpp"

namespace hgros::cli {

/// How far a process or program of a robot has come.
enum class UnitStage {
  kWaits,        ///< To be started.
  kBegun,        ///< Its process runs.
  kConstructed,  ///< A program is constructed at once.
  kJoined,
  kRunning,
  kEnds,   ///< Has been told to.
  kEnded,  ///< And is not started again.
};

/// A process or program, as its starter knows it.
struct StartedUnit {
  using Clock = std::chrono::steady_clock;

  const RobotUnit* setup;
  const RobotProcess* process = nullptr;  ///< Or a program.
  const RobotProgram* program = nullptr;
  UnitStage stage = UnitStage::kWaits;
  std::unique_ptr<UnitProcess> running{};
  int status = 0;  ///< Of its last end.
  std::uint64_t starts = 0;
  Clock::time_point started{};                           ///< The last time.
  bool remote = false;                                   ///< `running` is a relay to another host.
  bool over = false;                                     ///< The relay has told that what runs there has ended.
  bool unreached = false;                                ///< Its host could not be reached.
  Clock::time_point over_at = Clock::time_point::max();  ///< The relay has ended without that: when it is certain.
  Clock::time_point kill_at = Clock::time_point::max();  ///< It was told to end, or see `alone`.
  std::map<std::string, Clock::time_point> alone{};      ///< Components that are constructed again; the latest time.
  bool again = false;                                    ///< Is to be started again when it has ended.
  Clock::time_point due{};                               ///< When it is started.
  RestartPauses restarts{};
  std::map<std::string, std::uint64_t> runs{};  ///< How often each component has begun to run.
  std::map<std::string, std::string> ended{};   ///< Components that ended by themselves: "failed" or "finished".
  bool failed = false;                          ///< A component of it, or its end.
  bool reported = false;                        ///< Its first failure.

  [[nodiscard]] bool has_joined() const noexcept {
    return stage >= UnitStage::kJoined && stage < UnitStage::kEnds && !again;
  }
  [[nodiscard]] bool begins() const { return stage < UnitStage::kRunning; }
  [[nodiscard]] bool runs_components() const { return process != nullptr && stage == UnitStage::kRunning && !again; }

  /// Of one that runs: adds what its starter waits for. `reads`: also its reports.
  void AddTo(std::vector<pollfd>& watched, bool reads) const;
  /// What a process that starts waits for, if that takes long; empty: nothing. `joining`: all have been
  /// constructed; `released`: all may run.
  [[nodiscard]] std::string WhatIsLate(bool joining, bool released) const;
  /// To a process that runs.
  void Send(const RunOrder& order);
  /// Without those that have ended and are not started again.
  [[nodiscard]] static std::size_t CountLasting(const RobotGraph::Subscribers& subscribers,
                                                const std::vector<StartedUnit>& units);
  /// Of one channel.
  [[nodiscard]] static std::uint64_t CountLasting(const std::map<std::string, RobotGraph::Subscribers>& subscribers,
                                                  const std::string& channel, const std::vector<StartedUnit>& units);
  /// Its components are constructed, and may join. Those of a robot that runs wait for the others that have joined.
  void Join(const RobotGraph& graph, const std::vector<StartedUnit>& units);
  /// Its components have joined, and may run.
  void Release();

  /// It is killed if it has not ended after a while, or at `latest`.
  void TellToEnd(Clock::time_point latest = Clock::time_point::max());
  /// It saves the state of a component. That is no reason to kill it.
  void AwaitState();
  /// It has nothing more to save, or hangs.
  void AwaitEnd();
  /// It starts again, soon.
  void EndHanging(Clock::time_point latest);
  /// Its main thread may hang. False: it was asked already, and is to be killed.
  [[nodiscard]] bool AskLate();
  /// Of one that has ended: whether what it has started on another host may run on. Without a connection, that ends
  /// within `most`.
  [[nodiscard]] bool MayRunOn(std::chrono::seconds most);

  /// A component is constructed again alone. If that takes too long, its process is.
  void AwaitAlone(const std::string& component);
  void NoteAlone(const std::string& component);
  /// Of one that is late: a component that is constructed again alone may hang.
  [[nodiscard]] bool HangsAlone() const { return !alone.empty() && !again && stage != UnitStage::kEnds; }
  /// Of a process that has ended by itself: all its components had ended, some before they knew that they are to be
  /// constructed again.
  [[nodiscard]] bool MissedAgain() const;

 private:
  void KillIfLate();
};

}  // namespace hgros::cli
