#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

#include "viewer/data/scene_shapes.hpp"

namespace hgros::viewer {

/// What a robot's description shows on one of its links.
struct RobotShape {
  enum class Kind : std::uint8_t { kBox, kSphere, kCylinder, kMesh };
  std::string link;  ///< The frame that moves it.
  Eigen::Isometry3d T_link_shape = Eigen::Isometry3d::Identity();
  Kind kind = Kind::kBox;
  Eigen::Vector3d size = Eigen::Vector3d::Ones();  ///< Metres: edges; diameters, and height along z; of meshes factors.
  std::string mesh;                                ///< As the description names the file; empty: not a mesh.
  Rgba color = MakeRgba(190, 190, 190);
  bool colored = false;  ///< By a material of the description; else a mesh has its own colours.
};

enum class RobotSide : std::uint8_t { kVisual, kCollision };

/// What a URDF shows of its links. Returns what is wrong with it, in a sentence, or nothing; then `shapes` is what it
/// was before. `prefix` is put before every link's name.
[[nodiscard]] std::string ReadRobot(const std::string& urdf, const std::string& prefix, RobotSide side,
                                    std::vector<RobotShape>& shapes);

}  // namespace hgros::viewer
