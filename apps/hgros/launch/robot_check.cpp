#include "launch/robot_check.hpp"

#include <utility>

#include "check/ignored_findings.hpp"
#include "launch/robot_graph.hpp"
#include "trial/component_trial.hpp"

namespace hgros::cli {

CheckedRobot CheckRobot(const RobotFile& robot, const ComponentCatalog& catalog, Pause& pause) {
  std::vector<ComponentSetup> setups;
  for (const RobotComponent& one : robot.components) setups.push_back(one.setup);
  CheckedRobot checked;
  for (TriedComponent& tried : TryComponents(setups, catalog, pause)) {
    const RobotComponent& component = *robot.FindComponent(tried.name);
    if (tried.description && tried.description->state.empty() && component.checkpoint.count() > 0) {
      checked.findings.push_back(
          {true, component.at,
           "Component \"" + tried.name + "\" has a checkpoint, but " + component.setup.type + " cannot be saved.",
           "Give its class Save() and Restore(), or remove the key checkpoint."});
    }
    if (tried.description) {
      checked.descriptions.push_back(*std::move(tried.description));
    } else {
      for (const Error& fault : tried.faults) {
        const FilePosition at = fault.where().empty() ? component.at : FilePosition::From(fault.where());
        checked.findings.push_back({true, at, fault.sentence(), fault.mend()});
      }
    }
  }
  IgnoreComments comments;
  for (RobotFinding& one : RobotGraph(robot, checked.descriptions).Check()) {
    if (one.fault || !comments.Ignore(one.at, one.channel)) checked.findings.push_back(std::move(one));
  }
  return checked;
}

}  // namespace hgros::cli
