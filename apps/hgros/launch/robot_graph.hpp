#pragma once

#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/component/component_description.hpp"
#include "hgros/placement/robot_file.hpp"

namespace hgros::cli {

/// Something that a robot lacks, or that its components do not agree on.
struct RobotFinding {
  bool fault = false;  ///< Otherwise a warning: a program, or another robot, may have what is missing.
  FilePosition at;     ///< Of the wrong value, or of the component.
  std::string what;
  std::string fix;
  std::string channel = {};  ///< Or the service that it is about, if any.

  [[nodiscard]] std::string Text() const { return at.ToString() + ": " + what + (fix.empty() ? "" : " " + fix); }
};

/// The hypergraph of a robot file, as its components declare it.
class RobotGraph {
 public:
  /// `descriptions` has those of the components that could be constructed, in any order. Borrows the robot.
  RobotGraph(const RobotFile& robot, std::vector<ComponentDescription> descriptions);

  /// Types that do not fit, and channels and services that have only one end.
  [[nodiscard]] std::vector<RobotFinding> Check() const;
  struct Subscribers {
    std::size_t here = 0;               ///< Nodes of the process itself.
    std::set<std::string> elsewhere{};  ///< Other processes that it can find.

    [[nodiscard]] std::size_t count() const noexcept { return here + elsewhere.size(); }
  };
  /// The channels on which a process publishes, with their subscribers in the robot, if there are any. `moved`: a
  /// component that runs in that process, whatever the file says of it.
  [[nodiscard]] std::map<std::string, Subscribers> FindSubscribers(const RobotProcess& process,
                                                                   std::string_view moved = {}) const;
  /// Their number.
  [[nodiscard]] std::map<std::string, std::size_t> SubscribersOf(const RobotProcess& process) const;
  /// The same of the outputs of one component, if that ran in the process.
  [[nodiscard]] std::map<std::string, Subscribers> FindSubscribersOfMoved(std::string_view component,
                                                                          const RobotProcess& process) const;

  /// Whether one of two components subscribes to what the other one publishes.
  [[nodiscard]] bool Meet(std::string_view one, std::string_view other) const;

  /// Whether a component can move.
  [[nodiscard]] bool HasMoving() const noexcept { return moving_; }
  /// The channels that lead from one process or program to another, also those of services and, between components
  /// that use transforms, theirs, wherever the components that can move run.
  [[nodiscard]] std::set<std::string> ChannelsFrom(std::string_view from, std::string_view to) const;

 private:
  struct End {
    const RobotComponent* component;  // Or a program, which starts after the components.
    const RobotProgram* program;
    std::string type;  // Empty: any.
    bool moves;        // The component can.

    [[nodiscard]] const std::string& name() const { return program != nullptr ? program->name : component->setup.name; }
    [[nodiscard]] const std::string& unit() const { return program != nullptr ? program->name : component->process; }
    [[nodiscard]] const FilePosition& at() const { return program != nullptr ? program->at : component->at; }
  };
  using Ends = std::map<std::string, std::vector<End>>;
  struct Pair {
    End request;
    std::string reply;
  };
  using Pairs = std::map<std::string, std::vector<Pair>>;

  void Add(const RobotProgram& program);
  // Whether an endpoint of the process names the channel.
  [[nodiscard]] bool IsListed(const End& end, const std::string& channel) const;
  // Whether a program that does not say what it publishes, or an endpoint for all channels, may bring any.
  [[nodiscard]] bool MayComeFromOutside(const End& end) const;
  [[nodiscard]] bool CanRunIn(const End& end, std::string_view unit) const;
  void CheckChannels(std::vector<RobotFinding>& findings) const;
  void CheckServices(std::vector<RobotFinding>& findings) const;

  const RobotFile& robot_;
  bool moving_ = false;
  Ends inputs_;  // By channel, like the outputs.
  Ends outputs_;
  std::vector<End> transforming_;  // They set transforms, or look them up.
  Pairs served_;                   // By service, like the calls.
  Pairs called_;
};

}  // namespace hgros::cli
