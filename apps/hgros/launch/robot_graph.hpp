#pragma once

#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/component/component_description.hpp"
#include "hgros/placement/robot_file.hpp"
#include "launch/robot_finding.hpp"

namespace hgros::cli {

/// The hypergraph of a robot file, as its components declare it.
class RobotGraph {
 public:
  /// `descriptions` has those of the components that could be constructed, in any order. Borrows the robot.
  RobotGraph(const RobotFile& robot, std::vector<ComponentDescription> descriptions);

  /// Types that do not fit, and channels and services that have only one end.
  [[nodiscard]] std::vector<RobotFinding> Check() const;
  /// The channels on which a process publishes, with the number of their subscribers in the robot: nodes of the process
  /// itself, and other processes that it can find.
  [[nodiscard]] std::map<std::string, std::size_t> SubscribersOf(const RobotProcess& process) const;

  /// The channels that lead from one process to another, also those of services.
  [[nodiscard]] std::set<std::string> ChannelsFrom(std::string_view from, std::string_view to) const;

 private:
  struct End {
    const RobotComponent* component;
    std::string type;  // Empty: any.
  };
  using Ends = std::map<std::string, std::vector<End>>;
  struct Pair {
    End request;
    std::string reply;
  };
  using Pairs = std::map<std::string, std::vector<Pair>>;

  // Whether an endpoint of the component's process names the channel.
  [[nodiscard]] bool IsListed(const RobotComponent& component, const std::string& channel) const;
  // Whether a program of the robot, or an endpoint for all channels, may bring any.
  [[nodiscard]] bool MayComeFromOutside(const RobotComponent& component) const;
  void CheckChannels(std::vector<RobotFinding>& findings) const;
  void CheckServices(std::vector<RobotFinding>& findings) const;

  const RobotFile& robot_;
  Ends inputs_;  // By channel, like the outputs.
  Ends outputs_;
  Pairs served_;  // By service, like the calls.
  Pairs called_;
};

}  // namespace hgros::cli
