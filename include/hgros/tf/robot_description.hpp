#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/base/export.hpp"
#include "hgros/tf/stamped_edge.hpp"
#include "hgros/tf/transform_tree.hpp"

namespace hgros {

struct JointPosition {
  std::string_view name;
  double position = 0;  ///< rad, or m for a prismatic joint
};

/// foxglove::JointStates, or any type with its fields.
template <class T>
concept JointStatesMessage = requires(const T& states) {
  states.timestamp().seconds();
  states.joints().begin()->name();
  states.joints().begin()->position();
};

/// A robot's links and joints from its URDF. Fixed joints are static edges; joint states move the other edges.
/// Thread safety: as a value; reading is const.
class HGROS_EXPORT RobotDescription {
 public:
  /// `prefix` is put before every link name, for robots that share a tree.
  /// Errors: throws Error if the text cannot be read or is not URDF.
  [[nodiscard]] static RobotDescription FromFile(const std::filesystem::path& path, std::string_view prefix = {});
  [[nodiscard]] static RobotDescription FromText(const std::string& urdf, std::string_view prefix = {});

  /// The link without a parent, with the prefix.
  [[nodiscard]] const std::string& root() const noexcept;
  /// The joints that have a position of their own, by name.
  [[nodiscard]] const std::vector<std::string>& joints() const noexcept;

  /// All fixed joints as static edges, for Transforms::ToStaticTF.
  [[nodiscard]] std::vector<StampedEdge> FixedEdges() const;
  /// The named joints as edges, for Transforms::ToTF, together with joints that mimic them. Names that are not movable
  /// joints of the robot are ignored.
  /// Errors: for a message, throws Error if its stamp is not a time; SetJoints returns that as a result.
  [[nodiscard]] std::vector<StampedEdge> EdgesAt(Time stamp, std::span<const JointPosition> positions) const;
  template <JointStatesMessage T>
  [[nodiscard]] std::vector<StampedEdge> EdgesAt(const T& states) const {
    std::vector<JointPosition> positions;
    for (const auto& joint : states.joints()) positions.push_back({joint.name(), joint.position()});
    const std::optional<Time> stamp = StampOf(states.timestamp().seconds(), states.timestamp().nanos());
    if (!stamp) throw Error(NoTime().text());
    return EdgesAt(*stamp, positions);
  }

  /// Sets every fixed joint in a tree. Stops at the first edge that is refused.
  SetResult SetFixed(TransformTree& tree) const;
  /// Sets the joints as EdgesAt returns them. Stops at the first edge that is refused.
  SetResult SetJoints(TransformTree& tree, Time stamp, std::span<const JointPosition> positions) const;
  template <JointStatesMessage T>
  SetResult SetJoints(TransformTree& tree, const T& states) const {
    return StampOf(states.timestamp().seconds(), states.timestamp().nanos()) ? SetAll(tree, EdgesAt(states)) : NoTime();
  }

 private:
  // Empty if the stamp is not a time in nanoseconds.
  static std::optional<Time> StampOf(std::int64_t seconds, std::int64_t nanos) noexcept;
  static SetResult NoTime();
  static SetResult SetAll(TransformTree& tree, std::span<const StampedEdge> edges);

  struct Model;
  explicit RobotDescription(std::shared_ptr<const Model> model) : model_(std::move(model)) {}
  std::shared_ptr<const Model> model_;
};

}  // namespace hgros
