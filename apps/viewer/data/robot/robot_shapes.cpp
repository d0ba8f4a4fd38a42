#include "viewer/data/robot/robot_shapes.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "viewer/data/robot/robot_model.hpp"
#include "viewer/data/robot/robot_pose.hpp"

namespace hgros::viewer {
namespace {

bool SetGeometry(const urdf::GeometrySharedPtr& geometry, RobotShape& shape) {
  if (!geometry) return false;
  switch (geometry->type) {
    case urdf::Geometry::BOX: {
      const auto& box = static_cast<const urdf::Box&>(*geometry);
      shape.kind = RobotShape::Kind::kBox;
      shape.size = {box.dim.x, box.dim.y, box.dim.z};
      break;
    }
    case urdf::Geometry::SPHERE:
      shape.kind = RobotShape::Kind::kSphere;
      shape.size.setConstant(2 * static_cast<const urdf::Sphere&>(*geometry).radius);
      break;
    case urdf::Geometry::CYLINDER: {
      const auto& cylinder = static_cast<const urdf::Cylinder&>(*geometry);
      shape.kind = RobotShape::Kind::kCylinder;
      shape.size = {2 * cylinder.radius, 2 * cylinder.radius, cylinder.length};
      break;
    }
    case urdf::Geometry::MESH: {
      const auto& mesh = static_cast<const urdf::Mesh&>(*geometry);
      shape.kind = RobotShape::Kind::kMesh;
      shape.size = {mesh.scale.x, mesh.scale.y, mesh.scale.z};
      shape.mesh = mesh.filename;
      break;
    }
    default: return false;
  }
  return shape.size.allFinite();
}

void SetColor(const urdf::MaterialSharedPtr& material, RobotShape& shape) {
  if (!material || !material->texture_filename.empty()) return;
  const auto byte = [](float part) {
    return std::isfinite(part) ? static_cast<unsigned>(std::lround(std::clamp(part, 0.0F, 1.0F) * 255)) : 0U;
  };
  const auto& color = material->color;
  shape.color = MakeRgba(byte(color.r), byte(color.g), byte(color.b), byte(color.a));
  shape.colored = true;
}

}  // namespace

std::string ReadRobot(const std::string& urdf, const std::string& prefix, RobotSide side,
                      std::vector<RobotShape>& shapes) {
  const auto model = ReadRobotModel(urdf);
  if (!model) return "The robot's description is not a URDF.";
  std::vector<RobotShape> read;
  for (const auto& [name, link] : model->links_) {
    const auto add = [&, &name = name](const urdf::Pose& origin, const urdf::GeometrySharedPtr& geometry,
                                       const urdf::MaterialSharedPtr& material) {
      RobotShape shape;
      shape.link = prefix + name;
      shape.T_link_shape = RobotPose(origin);
      if (!SetGeometry(geometry, shape)) return;
      SetColor(material, shape);
      read.push_back(std::move(shape));
    };
    if (side == RobotSide::kVisual) {
      for (const auto& visual : link->visual_array) add(visual->origin, visual->geometry, visual->material);
    } else {
      for (const auto& collision : link->collision_array) add(collision->origin, collision->geometry, nullptr);
    }
  }
  shapes = std::move(read);
  return {};
}

}  // namespace hgros::viewer
