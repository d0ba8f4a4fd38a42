#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hgros/component/component_catalog.hpp"
#include "hgros/component/component_move.hpp"
#include "hgros/placement/robot_file.hpp"
#include "hosting/component_reports.hpp"
#include "hosting/hosted_components.hpp"

namespace hgros::cli {

/// The components that come to a process or leave it while they run, as the starter orders. A step that cannot be done
/// is reported, and the component stays as it is.
///
/// Threading: as HostedComponents.
class ComponentMoves {
 public:
  using Clock = std::chrono::steady_clock;

  /// Borrows all of them.
  ComponentMoves(Session& session, HostedComponents& hosted, ComponentReports& reports, const RobotFile& robot,
                 const ComponentCatalog& catalog)
      : session_(session), hosted_(hosted), reports_(reports), robot_(robot), catalog_(catalog) {}

  void Obey(const RunOrder::Move& order);
  /// Does what is due. Returns when more is.
  [[nodiscard]] Clock::time_point Work();

 private:
  struct Leaving {
    std::unique_ptr<LeavingComponent> place{};  // Once it is held.
    std::map<std::string, bool> any_type{};     // By input.
    bool left = false;
    std::optional<Clock::time_point> dropped_until{};  // It waits for no publisher any more, and ends by then.
    std::uint64_t lost = 0;                            // Messages.
    std::uint64_t attempt = 0;
  };
  struct Arriving {
    std::unique_ptr<ArrivingComponent> place;
    std::vector<RunOrder::Move::Users> awaited;  // Before it is ready.
    Clock::time_point deadline;
    Clock::time_point look_again = Clock::time_point::max();
    bool begun = false;
  };

  void Do(const RunOrder::Move& order);
  void Look(const std::string& name);
  void Receive(const RunOrder::Move& order);
  static void SetAwaited(const RunOrder::Move& order, Arriving& one);
  void Hold(const RunOrder::Move& order);
  void Restore(const RunOrder::Move& order);
  void Begin(const std::string& name);
  void Drop(const std::string& name);
  [[nodiscard]] bool Joined(const Arriving& one, std::string& lacks) const;
  // The next two return when more is due.
  Clock::time_point Await(const std::string& name, Arriving& one);
  Clock::time_point HandOver(const std::string& name, Leaving& one);
  void EndLeaving(const std::string& name);
  [[nodiscard]] RunReport ReportOf(const std::string& name, RunOrder::Move::Step step) const;
  void Tell(const std::string& name, RunOrder::Move::Step step, const std::string& sentence = {});

  Session& session_;
  HostedComponents& hosted_;
  ComponentReports& reports_;
  const RobotFile& robot_;
  const ComponentCatalog& catalog_;
  std::map<std::string, Leaving> leaving_;
  std::map<std::string, Arriving> arriving_;
  std::map<std::string, std::uint64_t> attempts_;  // Of the last order.
};

}  // namespace hgros::cli
