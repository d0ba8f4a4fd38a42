#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

#include "viewer/data/shapes/scene_shapes.hpp"

namespace hgros::viewer {

/// A shape of one link of a robot's description.
struct RobotShape {
  enum class Kind : std::uint8_t { kBox, kSphere, kCylinder, kMesh };
  std::string link;  ///< The frame it moves with.
  Eigen::Isometry3d T_link_shape = Eigen::Isometry3d::Identity();
  Kind kind = Kind::kBox;
  Eigen::Vector3d size =
      Eigen::Vector3d::Ones();  ///< Meters: edges, or diameters and height along z. Meshes: scale factors.
  std::string mesh;             ///< The file's name in the description; empty: not a mesh.
  Rgba color = MakeRgba(190, 190, 190);
  bool colored = false;  ///< Has the color of a material. Otherwise a mesh has its own colors.
};

enum class RobotSide : std::uint8_t { kVisual, kCollision };

/// Reads the shapes of a URDF's links. Returns what is wrong, as a sentence, or nothing. After an error, `shapes` is
/// unchanged. `prefix` is put before every link's name.
[[nodiscard]] std::string ReadRobot(const std::string& urdf, const std::string& prefix, RobotSide side,
                                    std::vector<RobotShape>& shapes);

}  // namespace hgros::viewer
