#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "hgros/placement/robot_file.hpp"

namespace hgros::cli {

/// The part of a robot file that runs on one host, and where the file will be.
struct ExportedRobot {
  RobotFile robot;
  std::string name;                                   ///< Of the robot.
  std::string host = {};                              ///< Of the option --host.
  std::filesystem::path file;                         ///< Absolute.
  std::map<std::string, std::string> variables = {};  ///< Of the environment, which the robot and its file use.
  std::vector<std::string> overrides = {};            ///< PATH=VALUE of --set.

  /// Without those that have no components.
  [[nodiscard]] std::vector<const RobotProcess*> Processes() const;
  /// Runs a process alone. `hgros`: the program.
  [[nodiscard]] std::vector<std::string> CommandOf(const RobotProcess& process, const std::string& hgros) const;
  /// Of the robot and the unit.
  [[nodiscard]] std::map<std::string, std::string> VariablesOf(const RobotUnit& unit) const;
  [[nodiscard]] bool HasEssentialComponent(const RobotProcess& process) const;
};

/// A file that an export writes.
struct ExportedFile {
  std::string name;
  std::string text;
};

}  // namespace hgros::cli
