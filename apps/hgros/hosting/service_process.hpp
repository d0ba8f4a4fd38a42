#pragma once

#include <string_view>

#include "hgros/component/component_catalog.hpp"
#include "hgros/placement/robot_file.hpp"

namespace hgros::cli {

class Pause;

/// How a process under systemd ends when one of its essential components has ended; elsewhere it is 0 and 1. The units
/// that `hgros export` writes have these numbers.
enum ServiceExit : int {
  kEssentialFinished = 10,
  kEssentialFailed = 11,
};

/// Runs the components of a process in this one, without a starter: as a service of systemd, or in a container. It
/// constructs, joins, waits for the subscribers that the robot file says, and starts. systemd learns of each step, and
/// that the process is alive: while its main thread runs and the session answers it.
///
/// Ends on SIGTERM, when all components have ended by themselves, when an essential one has, and when one has failed in
/// a process that is started again. Returns the exit code.
///
/// Threading: call it before other threads exist.
/// Errors:    throws Error if a component cannot be constructed or joined.
[[nodiscard]] int RunAsService(const RobotFile& robot, std::string_view process, const ComponentCatalog& catalog,
                               Pause& pause);

}  // namespace hgros::cli
