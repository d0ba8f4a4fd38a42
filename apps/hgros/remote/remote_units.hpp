#pragma once

#include <chrono>
#include <map>
#include <string>
#include <vector>

#include "hgros/component/component_catalog.hpp"
#include "hgros/component/component_description.hpp"
#include "hgros/placement/robot_file.hpp"
#include "hgros/yaml/document.hpp"
#include "launch/kept_component.hpp"
#include "processes/unit_process.hpp"
#include "remote/remote.pb.h"

namespace hgros::cli {

/// The starter tells every second that it is there. What it has started on another host ends if it is silent for so
/// long.
inline constexpr std::chrono::seconds kFarSilence{8};
/// So when the connection is lost, it has ended after this time.
inline constexpr auto kFarEnd = std::chrono::ceil<std::chrono::seconds>(kFarSilence + kEndPatience);

/// The processes and programs of a robot that run on other hosts, and what these need to start them.
class RemoteUnits {
 public:
  /// `document`: the assembled robot file. `networks`: as HostNetworks() makes them. Borrows the robot. Throws Error if
  /// a library cannot be read.
  RemoteUnits(const RobotFile& robot, const yaml::Document& document, std::map<std::string, std::string> networks,
              const std::vector<ComponentDescription>& descriptions, const ComponentCatalog& catalog);

  /// In a child of a starter: starts it on its host, and stays between both ends until it has ended. Returns the exit
  /// code, or ends this process by the signal that has ended the other one.
  [[nodiscard]] int Run(int socket, const RobotUnit& unit, const KeptComponents& kept) const;

 private:
  [[nodiscard]] RemoteOrder StartOf(const RobotUnit& unit) const;

  const RobotFile& robot_;
  const std::string file_;
  const std::string text_;
  const std::map<std::string, std::string> networks_;      // By process.
  std::map<std::string, RemoteOrder::Library> libraries_;  // By component, like the next one.
  std::map<std::string, std::map<std::string, std::uint64_t>> fingerprints_;
};

/// What differs between the component libraries of the starter's host and those of this one: one sentence for each.
/// `descriptions` are those of the components here.
[[nodiscard]] std::vector<std::string> LibraryDifferences(const RemoteOrder::Start& start,
                                                          const std::vector<ComponentDescription>& descriptions,
                                                          const ComponentCatalog& catalog);

}  // namespace hgros::cli
