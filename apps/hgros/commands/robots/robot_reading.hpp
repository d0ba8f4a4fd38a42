#pragma once

#include <string>
#include <vector>

#include "hgros/placement/robot_file.hpp"
#include "terminal/console.hpp"

namespace hgros::cli {

/// With the values of --set. Throws UsageError if one has no path or no value.
[[nodiscard]] RobotFileOptions WithSet(const std::vector<std::string>& set, RobotFileOptions options);
/// The robot file of a command. Says all faults but the last one, which it throws.
[[nodiscard]] RobotFile ReadRobot(Console& console, const std::string& file, const RobotFileOptions& options);

}  // namespace hgros::cli
