#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/export.hpp"
#include "hgros/tf/transform_tree.hpp"

namespace hgros {

struct JointPosition {
  std::string_view name;
  double position = 0;  ///< rad, or m for a prismatic joint
};

/// foxglove::JointStates, and whatever has its fields.
template <class T>
concept JointStatesMessage = requires(const T& states) {
  states.timestamp().seconds();
  states.joints().begin()->name();
  states.joints().begin()->position();
};

/// A robot's links and joints from its URDF: fixed joints are static edges, the others edges that joint states move.
/// Thread safety: as a value; reading is const.
class HGROS_EXPORT RobotDescription {
 public:
  /// `prefix` is put before every link's name, for robots that share a tree.
  /// Errors: throws Error if it cannot be read or is no URDF.
  [[nodiscard]] static RobotDescription FromFile(const std::filesystem::path& path, std::string_view prefix = {});
  [[nodiscard]] static RobotDescription FromText(const std::string& urdf, std::string_view prefix = {});

  /// The link that hangs below nothing, with the prefix.
  [[nodiscard]] const std::string& root() const noexcept;
  /// The joints that have a position of their own, by name.
  [[nodiscard]] const std::vector<std::string>& joints() const noexcept;

  /// Sets every fixed joint. The first edge that is refused ends it.
  SetResult SetFixed(TransformTree& tree) const;
  /// Sets every joint of those names, and joints that mimic them. Names that are no movable joint of the robot are
  /// passed over. The first edge that is refused ends it.
  SetResult SetJoints(TransformTree& tree, Time stamp, std::span<const JointPosition> positions) const;
  template <JointStatesMessage T>
  SetResult SetJoints(TransformTree& tree, const T& states) const {
    std::vector<JointPosition> positions;
    for (const auto& joint : states.joints()) positions.push_back({joint.name(), joint.position()});
    const Time stamp{states.timestamp().seconds() * 1'000'000'000 + states.timestamp().nanos()};
    return SetJoints(tree, stamp, positions);
  }

 private:
  struct Model;
  explicit RobotDescription(std::shared_ptr<const Model> model) : model_(std::move(model)) {}
  std::shared_ptr<const Model> model_;
};

}  // namespace hgros
