#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "export/exported_robot.hpp"

namespace hgros::cli {

struct ContainerOptions {
  std::string image;              ///< Has hgros, the robot file, and what the robot needs.
  std::string command = "hgros";  ///< In the image.
};

/// A process or program of a robot, as container engines run it.
struct Container {
  const RobotUnit* unit;
  bool program = false;
  std::vector<std::string> command = {};
};

/// Processes first. Nice and priority become commands before the command, because engines have no settings for them.
/// Throws Error if the robot file is below /tmp, which the containers of a robot share.
[[nodiscard]] std::vector<Container> ContainersOf(const ExportedRobot& exported, const ContainerOptions& options);

/// Whether its container needs CAP_SYS_NICE.
[[nodiscard]] bool NeedsNice(const RobotUnit& unit);

/// A text in YAML that engines read as it is: quoted, and without variables, for which they would look.
[[nodiscard]] std::string EngineText(std::string_view text);
[[nodiscard]] std::string EngineList(const std::vector<std::string>& texts);

/// The numbers with commas between them.
[[nodiscard]] std::string CpuList(const std::vector<int>& cpus);

}  // namespace hgros::cli
