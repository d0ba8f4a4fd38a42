#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hgros/base/log.hpp"
#include "hgros/placement/robot_file.hpp"
#include "launch/kept_component.hpp"
#include "launch/robot_graph.hpp"
#include "launch/run.pb.h"
#include "launch/started_unit.hpp"

namespace hgros::cli {

/// Moves components from one process of a robot to another while they run. Until the new place has begun, the old one
/// can go on. If a step fails or a process dies, the component runs on in one of the two places.
///
/// Threading: as Starter.
class Mover {
 public:
  using Clock = std::chrono::steady_clock;

  struct Means {
    RobotFile& robot;
    const RobotGraph& graph;
    std::vector<StartedUnit>& units;
    KeptComponents& kept;
    std::function<void(const std::string& component, const std::string& process)> placed;  ///< May be empty.
    std::function<void(const StartedUnit& unit, const std::string& component, LogLevel level, const std::string& text)>
        say;
  };
  struct Result {
    bool moved;
    std::string sentence;  ///< Why not, and where the component runs.
  };

  explicit Mover(Means means) : means_(std::move(means)) {}

  /// To a process, or to the first process of a host. ResultOf() tells what became of it. Not while it moves.
  void Begin(const std::string& component, const std::string& to);
  /// Of the last move; none while that goes on.
  [[nodiscard]] std::optional<Result> ResultOf(const std::string& component) const;
  /// Whether one of the places still has to do with it.
  [[nodiscard]] bool Moves(const std::string& component) const { return moves_.contains(component); }

  /// What a place reports.
  void Take(const StartedUnit& from, const RunOrder::Move& report);
  /// It cannot move any more, because something happened to it in the old place.
  void Disturb(const std::string& component, const std::string& why);
  /// A process has ended. Its stage says whether it will be started again.
  void NoteEnd(const StartedUnit& unit);
  /// Does what is due.
  void Work();
  [[nodiscard]] Clock::time_point due() const;
  /// Nothing more should be read from it, because the new place of a component does not read.
  [[nodiscard]] bool Congested(const StartedUnit& unit) const;

 private:
  enum class Stage { kWaits, kLooks, kReceives, kHolds, kRestores, kBegins, kHandsOver };
  struct Move {
    std::string component;
    std::uint64_t attempt;
    StartedUnit* from;
    StartedUnit* to;
    Stage stage = Stage::kWaits;
    Clock::time_point limit = Clock::time_point::max();
    Clock::time_point held{};
    RunOrder::Move moving{};  // The state and how far its inputs are.
    bool from_gone = false;   // Its process has ended, and the new place takes over.
    bool dropped = false;     // It does not wait for quiet publishers any more.
    int delays = 0;           // How often the new place got more time to read.
  };

  [[nodiscard]] StartedUnit* Find(const std::string& process) const;
  // Throws Error if the component cannot move there.
  [[nodiscard]] StartedUnit& PlaceFor(const std::string& to, const StartedUnit& from) const;
  // Messages keep their order only from a publisher that stays, or to a subscriber that does.
  [[nodiscard]] bool MustWait(const Move& move) const;
  void Look(Move& move);
  void Go(Move& move, Stage stage, std::chrono::milliseconds limit);
  [[nodiscard]] static RunOrder::Move OrderOf(const Move& move, RunOrder::Move::Step step);
  static void Send(StartedUnit& to, const RunOrder::Move& move);
  void SendReceive(Move& move, const RunOrder::Move& looked);
  void SendRestore(Move& move);
  void Relay(Move& move, const StartedUnit& from, const RunOrder::Move& report);
  void TakeLeft(Move& move, const std::string& sentence);
  void TakeLate(const StartedUnit& from, const RunOrder::Move& report);
  void HaveBegun(Move& move);
  void GiveUp(Move& move, const std::string& why);
  void NoteEndOfOld(Move& move, const StartedUnit& from);
  void NoteEndOfNew(Move& move, const StartedUnit& to);
  // Its old process constructs it again.
  void SendAdopt(const Move& move);
  void HandLate(Move& move);
  void Place(const Move& move, const StartedUnit& from, StartedUnit& to);

  const Means means_;
  std::uint64_t attempts_ = 0;
  std::map<std::string, Move> moves_;  // By component, like the next two.
  std::map<std::string, Result> results_;
  std::map<std::string, std::uint64_t> late_;  // Messages of an old place whose move is over.
};

}  // namespace hgros::cli
