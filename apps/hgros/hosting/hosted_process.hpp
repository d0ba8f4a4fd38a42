#pragma once

#include <sys/types.h>

#include "hgros/component/component_catalog.hpp"
#include "hgros/placement/robot_file.hpp"
#include "launch/kept_component.hpp"

namespace hgros::cli {

/// Runs the components of a process, as the starter at the other end of `socket` orders. Called in a child of the
/// starter, which has no other threads. Ends when the starter says so, on SIGTERM, and when all components have ended
/// by themselves. Components go on from what earlier instances have left in `kept`. Returns the exit code: 0 unless
/// something went wrong.
[[nodiscard]] int HostComponents(int socket, const RobotFile& robot, const RobotProcess& process,
                                 const ComponentCatalog& catalog, const KeptComponents& kept);

}  // namespace hgros::cli
