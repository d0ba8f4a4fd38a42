#pragma once

#include <vector>

#include "hgros/component/component_catalog.hpp"
#include "hgros/component/component_description.hpp"
#include "hgros/placement/robot_file.hpp"
#include "launch/robot_finding.hpp"

namespace hgros::cli {

class Pause;

/// What the components of a robot use, and what is wrong with them.
struct CheckedRobot {
  std::vector<ComponentDescription> descriptions;
  std::vector<RobotFinding> findings;
};

/// Constructs each component in another process, where nothing of it runs, and compares what they use. Leaves out
/// warnings that a comment in the file ignores.
///
/// Threading and errors: as TryComponents().
[[nodiscard]] CheckedRobot CheckRobot(const RobotFile& robot, const ComponentCatalog& catalog, Pause& pause);

}  // namespace hgros::cli
