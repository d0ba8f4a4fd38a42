#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace hgros::viewer {

/// A link of a robot's description, and how it is attached to its parent.
struct RobotLink {
  std::string name;                   ///< Name of its frame.
  std::optional<std::size_t> parent;  ///< Index of the parent; none: this is the root.
  std::string joint;                  ///< The joint to its parent; empty: this is the root.
  bool fixed = true;                  ///< The joint cannot move.
  Eigen::Isometry3d T_parent_link = Eigen::Isometry3d::Identity();  ///< With the joint at zero.
};

/// The links of a URDF, each after its parent. Empty if it is not a URDF. `prefix` is put before every link's name.
[[nodiscard]] std::vector<RobotLink> ReadRobotLinks(const std::string& urdf, const std::string& prefix);

struct PlacedLinks {
  std::map<std::string, Eigen::Isometry3d, std::less<>> T_fixed_link;
  std::vector<std::string> joints_at_zero;  ///< Movable joints of links that no transform moves.
  std::string at_fixed_frame;  ///< The root, if it is placed at the fixed frame because nothing else says where it is.
                               ///< Otherwise empty.
};

/// Places each link where `find` has it, or else relative to a placed link as the description says. If no link has a
/// place and `alone` is true, the root is placed at the fixed frame.
[[nodiscard]] PlacedLinks PlaceLinks(
    std::span<const RobotLink> links,
    const std::function<std::optional<Eigen::Isometry3d>(const std::string& link)>& find, bool alone);

}  // namespace hgros::viewer
