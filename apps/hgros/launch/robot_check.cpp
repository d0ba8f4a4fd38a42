#include "launch/robot_check.hpp"

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>

#include "check/ignored_findings.hpp"
#include "launch/robot_graph.hpp"
#include "terminal/visible_text.hpp"
#include "trial/component_trial.hpp"

namespace hgros::cli {
namespace {

namespace fs = std::filesystem;

bool IsProgram(const fs::path& file) {
  std::error_code error;
  return fs::is_regular_file(file, error) && access(file.c_str(), X_OK) == 0;
}

// Looks for the command of a program here, as execvp() will.
std::optional<RobotFinding> MissingCommand(const RobotProgram& program) {
  const std::string& name = program.command.front();
  const std::string shown = '"' + Visible(name) + '"';
  const auto finding = [&](std::string what, std::string fix) {
    return RobotFinding{false, program.at, "Program \"" + program.name + "\" cannot be started: " + what,
                        std::move(fix)};
  };
  if (name.find('/') != std::string::npos) {
    if (IsProgram(name)) return std::nullopt;
    return finding(shown + " is no program.", "Correct its path, which begins where `hgros run` is called.");
  }
  const auto own = program.env.find("PATH");
  const char* const inherited = std::getenv("PATH");
  std::istringstream folders(own != program.env.end() ? own->second
                             : inherited != nullptr   ? inherited
                                                      : "/bin:/usr/bin");
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (IsProgram(fs::path(folder.empty() ? "." : folder) / name)) return std::nullopt;
  }
  return finding("there is no program " + shown + " in PATH.", "Install it, or correct its name.");
}

}  // namespace

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
  for (const RobotProgram& program : robot.programs) {
    if (!robot.hosts.empty()) break;  // They may run elsewhere.
    if (std::optional<RobotFinding> missing = MissingCommand(program)) checked.findings.push_back(*std::move(missing));
  }
  IgnoreComments comments;
  for (RobotFinding& one : RobotGraph(robot, checked.descriptions).Check()) {
    if (one.fault || !comments.Ignore(one.at, one.channel)) checked.findings.push_back(std::move(one));
  }
  return checked;
}

}  // namespace hgros::cli
