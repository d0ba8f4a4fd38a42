#include "export/exported_robot.hpp"

#include <algorithm>

namespace hgros::cli {

std::vector<const RobotProcess*> ExportedRobot::Processes() const {
  std::vector<const RobotProcess*> processes;
  for (const RobotProcess& one : robot.processes) {
    if (!one.components.empty()) processes.push_back(&one);
  }
  return processes;
}

std::vector<std::string> ExportedRobot::CommandOf(const RobotProcess& process, const std::string& hgros) const {
  std::vector<std::string> command{hgros, "run", file.string(), "--process=" + process.name};
  if (!host.empty()) command.push_back("--host=" + host);
  for (const std::string& one : overrides) command.push_back("--set=" + one);
  return command;
}

std::map<std::string, std::string> ExportedRobot::VariablesOf(const RobotUnit& unit) const {
  std::map<std::string, std::string> all = unit.env;
  all.insert(variables.begin(), variables.end());
  return all;
}

bool ExportedRobot::HasEssentialComponent(const RobotProcess& process) const {
  return std::ranges::any_of(process.components,
                             [&](const std::string& one) { return robot.FindComponent(one)->essential; });
}

}  // namespace hgros::cli
