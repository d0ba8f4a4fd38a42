#pragma once

#include <poll.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hgros/component/component_catalog.hpp"
#include "hgros/placement/robot_file.hpp"
#include "launch/kept_component.hpp"
#include "processes/message_stream.hpp"
#include "processes/unit_process.hpp"
#include "remote/remote.pb.h"

namespace hgros::cli {

class Pause;

/// What ssh runs on another host for a starter: starts one process or program there as SshRelay orders on standard
/// input, and reports on standard output. Ends it when the starter says so, and when the starter, ssh or the network is
/// gone; kills what does not end then.
///
/// Threading: one thread, and no other in the process: it forks.
class FarEnd {
 public:
  explicit FarEnd(Pause& pause);
  FarEnd(const FarEnd&) = delete;
  FarEnd& operator=(const FarEnd&) = delete;
  ~FarEnd();

  /// Until the process or program has ended. Returns the exit code of the command: 0 if the starter has heard how.
  [[nodiscard]] int Run();

 private:
  using Clock = std::chrono::steady_clock;

  // Throws Error if something differs from the starter's host, or the unit cannot be started.
  void Start();
  void CheckLibraries(const RobotProcess& process) const;
  // Until there is an order or a report, or something is due.
  void Wait();
  void HearStarter();
  void Obey(const RunOrder& order);
  void HearUnit(bool ended);
  void EndUnit();
  void Tell(const RemoteReport& report);
  void TellEnd(int status);
  [[nodiscard]] bool over() const;

  Pause& pause_;
  MessageStream orders_;
  MessageStream reports_;
  const ComponentCatalog catalog_;
  std::optional<RemoteOrder::Start> start_;
  KeptComponents kept_;
  RobotFile robot_;
  const RobotProcess* process_ = nullptr;  // Or a program.
  OrphanGuard guard_;
  std::unique_ptr<UnitProcess> unit_;
  bool ends_ = false;  // The starter wants it to.
  bool gone_ = false;  // The starter.
  Clock::time_point heard_ = Clock::now();
  Clock::time_point kill_at_ = Clock::time_point::max();  // The unit was told to end.
};

}  // namespace hgros::cli
