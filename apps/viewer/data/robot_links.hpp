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

/// A link as the robot's description hangs it on another one.
struct RobotLink {
  std::string name;                                                 ///< Of its frame.
  std::optional<std::size_t> parent;                                ///< Its index; none: the root.
  std::string joint;                                                ///< That holds it; empty: the root.
  bool fixed = true;                                                ///< The joint moves nothing.
  Eigen::Isometry3d T_parent_link = Eigen::Isometry3d::Identity();  ///< While the joint stands at zero.
};

/// The links of a URDF, each after its parent; none if it is no URDF. `prefix` is put before every link's name.
[[nodiscard]] std::vector<RobotLink> ReadRobotLinks(const std::string& urdf, const std::string& prefix);

struct PlacedLinks {
  std::map<std::string, Eigen::Isometry3d, std::less<>> T_fixed_link;
  std::vector<std::string> joints_at_zero;  ///< Joints that could move, of links that no transform moves.
  std::string at_fixed_frame;               ///< The root, if nothing else says where it is; else empty.
};

/// Each link where `find` has it, or else where the description hangs it on a link that has a place. If there is none,
/// the root stands at the fixed frame, if `alone`.
[[nodiscard]] PlacedLinks PlaceLinks(
    std::span<const RobotLink> links,
    const std::function<std::optional<Eigen::Isometry3d>(const std::string& link)>& find, bool alone);

}  // namespace hgros::viewer
