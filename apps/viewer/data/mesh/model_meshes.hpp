#pragma once

#include <Eigen/Geometry>
#include <map>
#include <string>
#include <vector>

#include "viewer/data/shapes/scene_shapes.hpp"

namespace hgros::viewer {

/// The meshes that entities name or contain. Each is read once and kept while it is shown. Thread safety: none.
class ModelMeshes {
 public:
  /// Adds the triangles of `shapes.models` to `shapes.triangles`. Models that cannot be drawn are left out. Returns
  /// what is wrong with the first of these, as a sentence, or nothing.
  [[nodiscard]] std::string AddTo(SceneShapes& shapes);
  /// Distance from `at` to the nearest visible surface that AddTo added last, in the frame of the poses. Infinity if
  /// there is none within `within_m`.
  [[nodiscard]] double DistanceTo(const std::vector<SceneModel>& models, const Eigen::Vector3d& at,
                                  double within_m) const;

 private:
  struct Mesh {
    std::vector<TriangleCorner> corners;  ///< In its own frame. A color without alpha means no color.
    Eigen::AlignedBox3d box;              ///< Around them.
    std::string fault;
  };
  [[nodiscard]] static Mesh Read(const SceneModel& model);

  std::map<std::string, Mesh> meshes_;  ///< The key is the mesh's source.
};

}  // namespace hgros::viewer
