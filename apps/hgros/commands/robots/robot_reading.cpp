#include "commands/robots/robot_reading.hpp"

#include <utility>

#include "arguments/arguments.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {

RobotFileOptions WithSet(const std::vector<std::string>& set, RobotFileOptions options) {
  for (const std::string& one : set) {
    const std::size_t equals = one.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw UsageError("--set needs a path and a value, as in --set mapper.params.cell_size_m=0.1.");
    }
    options.overrides.push_back({one.substr(0, equals), one.substr(equals + 1), "--set " + one.substr(0, equals)});
  }
  return options;
}

RobotFile ReadRobot(Console& console, const std::string& file, const RobotFileOptions& options) {
  CheckedRobotFile checked = RobotFile::Check(file, options);
  if (checked.faults.empty()) return std::move(checked.robot);
  const ConfigError last = checked.faults.back();
  checked.faults.pop_back();
  for (const ConfigError& fault : checked.faults) console.Say(Visible(fault.what()));
  throw ConfigError(last);
}

}  // namespace hgros::cli
