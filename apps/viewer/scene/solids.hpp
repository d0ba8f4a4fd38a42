#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "viewer/data/scene_shapes.hpp"
#include "viewer/scene/gl_object.hpp"
#include "viewer/scene/shader_program.hpp"
#include "viewer/view/camera.hpp"

namespace hgros::viewer {

/// Cubes, spheres and cylinders: one mesh of size 1 for each of the three, and one draw call for all of a kind.
/// Thread: the one whose GL context is current.
class Solids {
 public:
  Solids();
  /// Positions are in the frame that they are drawn with.
  void Set(const SceneShapes& shapes);
  /// Those that hide what is behind them, or the others, which are to be drawn later.
  void Draw(const ViewMatrices& view, const RigidTransform& T_fixed_shapes, bool blended);
  [[nodiscard]] std::size_t gpu_bytes() const noexcept;

 private:
  /// A corner of a mesh of size 1 about the origin.
  struct Corner {
    std::array<float, 3> at;
    std::array<float, 3> normal;
  };
  struct Instance {
    std::array<float, 12> pose;  ///< Column by column.
    Rgba color;
    std::array<float, 2> scales;  ///< Of the bottom and the top.
  };
  struct Kind {
    GlVertexArray vertices;
    GlBuffer mesh, instances;
    std::size_t corners = 0, opaque = 0, blended = 0;
  };
  static std::vector<Corner> Cube();
  static std::vector<Corner> Sphere();
  static std::vector<Corner> Cylinder();
  void Set(Kind& kind, std::vector<Corner> (*mesh)(), std::span<const SolidShape> shapes);

  ShaderProgram program_;
  std::array<Kind, 3> kinds_;
};

}  // namespace hgros::viewer
