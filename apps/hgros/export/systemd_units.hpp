#pragma once

#include <string>
#include <vector>

#include "export/exported_robot.hpp"

namespace hgros::cli {

struct SystemdOptions {
  std::string user;     ///< Whom the services of the system run as; empty: those of systemctl --user.
  std::string command;  ///< The absolute path of hgros.
};

/// One service for each process and program, a target that starts and stops them together, and, if something is
/// essential, a second target that ends the first.
///
/// Errors: throws Error if the robot has a text that no unit can have.
[[nodiscard]] std::vector<ExportedFile> SystemdUnits(const ExportedRobot& exported, const SystemdOptions& options);

}  // namespace hgros::cli
