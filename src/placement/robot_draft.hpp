#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/placement/robot_file.hpp"
#include "hgros/yaml/reader.hpp"

namespace hgros {

/// Reads the sections of a robot file. Faults go to those of the values.
class RobotDraft {
 public:
  RobotDraft(const yaml::Document& document, yaml::Faults faults) : document_(document), faults_(faults) {}

  /// `read_key_files` and `host` as in RobotFileOptions.
  [[nodiscard]] RobotFile Read(bool read_key_files, std::string_view host);

 private:
  void ReadHost(const yaml::Field& field);
  void CheckHosts() const;
  void CheckPorts() const;
  void ReadHostOf(const yaml::Section& section, RobotUnit& unit) const;
  void ReadComponent(const yaml::Field& field);
  void ReadProcess(const yaml::Field& field);
  void ReadProgram(const yaml::Field& field);
  void ReadUnit(const yaml::Field& field, const yaml::Section& section, RobotUnit& unit);
  void ReadPlaces(const yaml::Value& list, RobotProcess& process);
  [[nodiscard]] Config ConfigOf(const yaml::Document* process, bool read_key_files) const;
  void PlaceOthers();
  void CheckNames() const;
  [[nodiscard]] std::vector<std::string> ComponentNames() const;

  const yaml::Document& document_;
  const yaml::Faults faults_;
  RobotFile robot_;
  std::map<std::string, yaml::Document> sections_;  // Of processes that have some.
  std::map<std::string, FilePosition> places_;      // Of components in the lists of processes.
};

/// The keys at the top of a robot file that a configuration file does not have.
[[nodiscard]] const std::vector<std::string>& RobotSections();
/// Whether a key at the top is no known one, and "components" is the nearest.
[[nodiscard]] bool IsNearComponents(std::string_view key);

}  // namespace hgros
