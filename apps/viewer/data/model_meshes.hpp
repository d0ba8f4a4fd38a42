#pragma once

#include <Eigen/Geometry>
#include <map>
#include <string>
#include <vector>

#include "viewer/data/scene_shapes.hpp"

namespace hgros::viewer {

/// The meshes that entities name or carry, each read once for as long as it is shown.
/// Thread safety: none.
class ModelMeshes {
 public:
  /// Adds the triangles of `shapes.models` to `shapes.triangles`. Returns what is wrong with the first one that cannot
  /// be drawn, in a sentence; the others are added.
  [[nodiscard]] std::string AddTo(SceneShapes& shapes);
  /// How far `at` is from the nearest surface of those that AddTo read last, in the frame of their poses; infinity:
  /// none of them was, or has alpha, or is as near as `within_m`.
  [[nodiscard]] double DistanceTo(const std::vector<SceneModel>& models, const Eigen::Vector3d& at,
                                  double within_m) const;

 private:
  struct Mesh {
    std::vector<TriangleCorner> corners;  ///< In its own frame; a colour without alpha is none.
    Eigen::AlignedBox3d box;              ///< Around them.
    std::string fault;
  };
  [[nodiscard]] static Mesh Read(const SceneModel& model);

  std::map<std::string, Mesh> meshes_;  ///< By where they are from.
};

}  // namespace hgros::viewer
