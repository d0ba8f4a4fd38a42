#include "viewer/data/robot/robot_links.hpp"

#include <set>
#include <utility>

#include "viewer/data/robot/robot_model.hpp"
#include "viewer/data/robot/robot_pose.hpp"

namespace hgros::viewer {

std::vector<RobotLink> ReadRobotLinks(const std::string& urdf, const std::string& prefix) {
  std::vector<RobotLink> links;
  const auto model = ReadRobotModel(urdf);
  if (!model || !model->root_link_) return links;
  std::vector<std::pair<urdf::LinkConstSharedPtr, std::optional<std::size_t>>> open = {{model->root_link_, {}}};
  std::set<std::string> seen;
  while (!open.empty()) {
    const auto [link, parent] = open.back();
    open.pop_back();
    if (!seen.insert(link->name).second) continue;  // Two joints may have the same child.
    RobotLink& read = links.emplace_back();
    read.name = prefix + link->name;
    read.parent = parent;
    if (parent && link->parent_joint) {
      const urdf::Joint& joint = *link->parent_joint;
      read.joint = joint.name;
      read.fixed = joint.type == urdf::Joint::FIXED;
      read.T_parent_link = RobotPose(joint.parent_to_joint_origin_transform);
    }
    const std::size_t index = links.size() - 1;
    // A stack: the first child comes next.
    for (auto child = link->child_links.rbegin(); child != link->child_links.rend(); ++child) {
      open.emplace_back(*child, index);
    }
  }
  return links;
}

PlacedLinks PlaceLinks(std::span<const RobotLink> links,
                       const std::function<std::optional<Eigen::Isometry3d>(const std::string& link)>& find,
                       bool alone) {
  PlacedLinks placed;
  std::vector<std::optional<Eigen::Isometry3d>> at(links.size());
  const auto hang = [&](const RobotLink& link) {
    if (!link.fixed) placed.joints_at_zero.push_back(link.joint);
  };
  bool any = false;
  for (std::size_t i = 0; i < links.size(); ++i) any |= (at[i] = find(links[i].name)).has_value();
  // Place the links above a link that has a place, ...
  for (std::size_t i = links.size(); i-- > 0;) {
    const RobotLink& link = links[i];
    if (!at[i] || !link.parent || at[*link.parent]) continue;
    at[*link.parent] = *at[i] * link.T_parent_link.inverse();
    hang(link);
  }
  if (!any && alone && !links.empty()) {
    at.front().emplace(Eigen::Isometry3d::Identity());
    placed.at_fixed_frame = links.front().name;
  }
  // ... and those below it.
  for (std::size_t i = 0; i < links.size(); ++i) {
    const RobotLink& link = links[i];
    if (!at[i] && link.parent && at[*link.parent]) {
      at[i] = *at[*link.parent] * link.T_parent_link;
      hang(link);
    }
    if (at[i]) placed.T_fixed_link.emplace(link.name, *at[i]);
  }
  return placed;
}

}  // namespace hgros::viewer
