#pragma once

#include <poll.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "hgros/placement/robot_file.hpp"
#include "launch/restart_pauses.hpp"
#include "launch/robot_graph.hpp"
#include "launch/run.pb.h"
#include "launch/unit_process.hpp"

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
  /// Of one that runs: adds what its starter waits for. `reads`: also its reports.
  void AddTo(std::vector<pollfd>& watched, bool reads) const {
    if (over_at == Clock::time_point::max()) watched.push_back({running->end_descriptor(), POLLIN, 0});
    const int events = (running->stream().unsent() > 0 ? POLLOUT : 0) | (reads ? POLLIN : 0);
    if (!running->stream_ended()) watched.push_back({running->stream().descriptor(), static_cast<short>(events), 0});
    if (running->output() >= 0) watched.push_back({running->output(), POLLIN, 0});
  }
  /// What a process that starts waits for, if that takes long; empty: nothing. `joining`: all have been
  /// constructed; `released`: all may run.
  [[nodiscard]] std::string WhatIsLate(bool joining, bool released) const {
    if (stage == UnitStage::kBegun) return "It still constructs its components.";
    if (stage == UnitStage::kConstructed && joining) return "It still waits for its subscribers.";
    return stage == UnitStage::kJoined && released ? "An Activate() of its components has not returned." : "";
  }
  /// To a process that runs.
  void Send(const RunOrder& order) {
    running->stream().Add(order);
    (void)running->stream().Write();  // If nobody reads it, the end of the process follows.
  }
  /// Its components are constructed, and may join. Those of a robot that runs wait for the others that have joined.
  void Join(const RobotGraph& graph, const std::vector<StartedUnit>& units) {
    RunOrder order;
    RunOrder::Join& join = *order.mutable_join();
    for (const auto& [channel, subscribers] : graph.FindSubscribers(*process)) {
      RunOrder::Output& output = *join.add_outputs();
      output.set_channel(channel);
      output.set_subscribers(subscribers.count());
      for (const StartedUnit& one : units) {
        if (!subscribers.elsewhere.contains(one.setup->name)) continue;
        if (one.has_joined()) output.set_ready(output.ready() + 1);
        if (one.stage == UnitStage::kEnded || one.unreached) output.set_subscribers(output.subscribers() - 1);
      }
    }
    Send(order);
  }
  /// Its components have joined, and may run.
  void Release() {
    RunOrder order;
    (void)order.mutable_start();
    Send(order);
  }
  /// A component is constructed again alone. If that takes too long, its process is.
  void AwaitAlone(const std::string& component) {
    alone[component] = Clock::now() + std::chrono::seconds(5);
    KillIfLate();
  }
  void NoteAlone(const std::string& component) {
    if (alone.erase(component) > 0) KillIfLate();
  }
  void KillIfLate() {
    if (stage == UnitStage::kEnds || again) return;
    kill_at = Clock::time_point::max();
    for (const auto& [component, latest] : alone) kill_at = std::min(kill_at, latest);
  }
  /// Of one that has ended: whether what it has started on another host may run on. Without a connection, that ends
  /// within `most`.
  [[nodiscard]] bool MayRunOn(std::chrono::seconds most) {
    if (!remote || over) return false;
    if (over_at == Clock::time_point::max()) over_at = Clock::now() + most;
    return Clock::now() < over_at;
  }
  /// Of a process that has ended by itself: all its components had ended, some before they knew that they are to be
  /// constructed again.
  [[nodiscard]] bool MissedAgain() const {
    return process != nullptr && !alone.empty() && std::ranges::all_of(process->components, [this](const auto& one) {
             return ended.contains(one) || alone.contains(one);
           });
  }
  [[nodiscard]] bool begins() const { return stage < UnitStage::kRunning; }
  [[nodiscard]] bool runs_components() const { return process != nullptr && stage == UnitStage::kRunning && !again; }
};

}  // namespace hgros::cli
