#pragma once

#include <map>
#include <string>

#include "hgros/placement/robot_file.hpp"
#include "launch/robot_graph.hpp"

namespace hgros::cli {

/// The network section, as YAML, of each process, and of each program that says what it exchanges, if that exchanges
/// messages with another host: its endpoints, exactly the channels that are used, and the keys of the hosts. Every host
/// computes the same. Throws ConfigError if a host that others must reach is not described, or the file contradicts
/// what is derived.
[[nodiscard]] std::map<std::string, std::string> HostNetworks(const RobotFile& robot, const RobotGraph& graph);

/// Throws Error unless the robot has that host (empty: none was named).
void RequireHost(const RobotFile& robot, const std::string& host);

/// What runs on that host, with these networks in addition to what the file says. Without a host: everything, and
/// networks only for what runs at home. Programs get theirs in HGROS_CONFIG. Throws ConfigError if the host's key
/// cannot be read.
[[nodiscard]] RobotFile PartOfHost(const RobotFile& robot, const std::string& host,
                                   const std::map<std::string, std::string>& networks);

}  // namespace hgros::cli
