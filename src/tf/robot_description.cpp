#include "hgros/tf/robot_description.hpp"

#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>
#include <utility>

#include "hgros/base/error.hpp"
#include "tf/transform_messages.hpp"

namespace hgros {
namespace {

RigidTransform OriginOf(const urdf::Pose& pose) {
  RigidTransform::Rotation rotation(pose.rotation.w, pose.rotation.x, pose.rotation.y, pose.rotation.z);
  rotation.normalize();
  return {rotation, Eigen::Vector3d(pose.position.x, pose.position.y, pose.position.z)};
}

// Links whose joints form a cycle keep each other alive: the last owner of the model breaks the cycle.
std::shared_ptr<const urdf::ModelInterface> Parse(const std::string& urdf) {
  const urdf::ModelInterfaceSharedPtr model = urdf::parseURDF(urdf);
  if (!model) return nullptr;
  return {model.get(), [model](const urdf::ModelInterface* /*model*/) {
            for (const auto& [name, link] : model->links_) {
              link->child_links.clear();
              link->child_joints.clear();
            }
          }};
}

}  // namespace

struct RobotDescription::Model {
  struct Mimic {
    std::string joint;
    double multiplier = 1;
    double offset = 0;
  };

  struct Joint {
    std::string parent;
    std::string child;
    RigidTransform origin;
    Eigen::Vector3d axis = Eigen::Vector3d::UnitX();
    bool slides = false;

    [[nodiscard]] RigidTransform At(double position) const {
      if (slides) return origin * RigidTransform({1, 0, 0, 0}, axis * position);
      return origin *
             RigidTransform(RigidTransform::Rotation(Eigen::AngleAxisd(position, axis)), Eigen::Vector3d::Zero());
    }
  };

  std::string root;
  std::vector<Joint> fixed;
  std::map<std::string, Joint, std::less<>> movable;
  std::vector<std::pair<std::string, Mimic>> mimics;
  std::vector<std::string> names;
};

RobotDescription RobotDescription::FromFile(const std::filesystem::path& path, std::string_view prefix) {
  std::ifstream file(path);
  std::ostringstream text;
  if (!file || !(text << file.rdbuf())) throw Error("The robot's description cannot be read.", path.string());
  try {
    return FromText(text.str(), prefix);
  } catch (const Error& error) {
    throw Error(error.what(), path.string());
  }
}

RobotDescription RobotDescription::FromText(const std::string& urdf, std::string_view prefix) {
  const std::shared_ptr<const urdf::ModelInterface> parsed = Parse(urdf);
  if (!parsed || !parsed->getRoot()) {
    throw Error("The robot's description is not valid URDF.", {},
                "The parser's message is on standard error; check_urdf prints it, too.");
  }
  auto model = std::make_shared<Model>();
  model->root = std::string(prefix) + parsed->getRoot()->name;
  for (const auto& [name, read] : parsed->joints_) {
    Model::Joint joint;
    joint.parent = std::string(prefix) + read->parent_link_name;
    joint.child = std::string(prefix) + read->child_link_name;
    joint.origin = OriginOf(read->parent_to_joint_origin_transform);
    if (read->type == urdf::Joint::FIXED) {
      model->fixed.push_back(std::move(joint));
      continue;
    }
    const bool turns = read->type == urdf::Joint::REVOLUTE || read->type == urdf::Joint::CONTINUOUS;
    joint.slides = read->type == urdf::Joint::PRISMATIC;
    if (!turns && !joint.slides) {
      throw Error("The joint \"" + name + "\" is floating or planar, which one position does not describe.", {},
                  "Set its edge with TransformTree::Set and leave it out of the description.");
    }
    joint.axis = Eigen::Vector3d(read->axis.x, read->axis.y, read->axis.z);
    if (!(joint.axis.norm() > 1e-9)) throw Error("The axis of the joint \"" + name + "\" has no direction.");
    joint.axis.normalize();
    if (read->mimic) {
      model->mimics.emplace_back(name,
                                 Model::Mimic{read->mimic->joint_name, read->mimic->multiplier, read->mimic->offset});
    } else {
      model->names.push_back(name);
    }
    model->movable.emplace(name, std::move(joint));
  }
  return RobotDescription(std::move(model));
}

const std::string& RobotDescription::root() const noexcept { return model_->root; }
const std::vector<std::string>& RobotDescription::joints() const noexcept { return model_->names; }

std::vector<StampedEdge> RobotDescription::FixedEdges() const {
  std::vector<StampedEdge> edges;
  for (const Model::Joint& joint : model_->fixed) edges.push_back({joint.parent, joint.child, {}, joint.origin});
  return edges;
}

std::vector<StampedEdge> RobotDescription::EdgesAt(Time stamp, std::span<const JointPosition> positions) const {
  std::vector<StampedEdge> edges;
  const auto add = [&](const Model::Joint& joint, double position) {
    edges.push_back({joint.parent, joint.child, stamp, joint.At(position)});
  };
  for (const JointPosition& given : positions) {
    const auto joint = model_->movable.find(given.name);
    if (joint == model_->movable.end()) continue;
    add(joint->second, given.position);
    for (const auto& [name, mimic] : model_->mimics) {
      if (mimic.joint != given.name) continue;
      add(model_->movable.find(name)->second, mimic.multiplier * given.position + mimic.offset);
    }
  }
  return edges;
}

SetResult RobotDescription::SetFixed(TransformTree& tree) const {
  for (const StampedEdge& edge : FixedEdges()) {
    SetResult set = tree.SetStatic(edge.parent, edge.child, edge.T_parent_child, "robot description");
    if (!set) return set;
  }
  return {};
}

SetResult RobotDescription::SetJoints(TransformTree& tree, Time stamp, std::span<const JointPosition> positions) const {
  return SetAll(tree, EdgesAt(stamp, positions));
}

std::optional<Time> RobotDescription::StampOf(std::int64_t seconds, std::int64_t nanos) noexcept {
  return tf::TimeOf(seconds, nanos);
}

SetResult RobotDescription::NoTime() {
  return {SetFault::kTooOld, "The joint states were refused: their timestamp is invalid."};
}

SetResult RobotDescription::SetAll(TransformTree& tree, std::span<const StampedEdge> edges) {
  for (const StampedEdge& edge : edges) {
    SetResult set = tree.Set(edge.parent, edge.child, edge.stamp, edge.T_parent_child, "joint states");
    if (!set) return set;
  }
  return {};
}

}  // namespace hgros
