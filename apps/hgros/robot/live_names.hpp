#pragma once

#include <string>
#include <vector>

#include "arguments/completion.hpp"
#include "robot/robot.hpp"

namespace hgros::cli {

/// The names of the running robot that complete a command line, sorted, at most after a quarter of a second. Those that
/// a terminal would obey are left out.
[[nodiscard]] std::vector<std::string> LiveNames(const Completion& completion, const Surroundings& surroundings);

}  // namespace hgros::cli
