#pragma once

#include <string>
#include <vector>

#include "hgros/placement/robot_file.hpp"
#include "terminal/console.hpp"

namespace hgros::cli {

/// The robot file of a command, with the values of its --set. Says all faults but the last one, which it throws.
[[nodiscard]] RobotFile ReadRobot(Console& console, const std::string& file, const std::vector<std::string>& set,
                                  RobotFileOptions options);

}  // namespace hgros::cli
