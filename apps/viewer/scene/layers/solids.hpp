#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "viewer/data/shapes/scene_shapes.hpp"
#include "viewer/scene/display.hpp"
#include "viewer/scene/gl/gl_object.hpp"
#include "viewer/scene/gl/shader_program.hpp"

namespace hgros::viewer {

/// Cubes, spheres and cylinders: one mesh of size 1 for each kind, and one draw call for all shapes of a kind. Thread:
/// the one whose GL context is current.
class Solids {
 public:
  Solids();
  /// Positions are in the frame given when they are drawn.
  void Set(const SceneShapes& shapes);
  /// Draws the opaque ones, or the transparent ones, which must come later.
  void Draw(const DrawContext& context, const RigidTransform& T_fixed_shapes, bool blended);
  [[nodiscard]] std::size_t gpu_bytes() const noexcept;

 private:
  /// A corner of a mesh of size 1 around the origin.
  struct Corner {
    std::array<float, 3> at;
    std::array<float, 3> normal;
  };
  struct Mesh {
    std::vector<Corner> corners;
    std::vector<std::uint16_t> indices;  ///< Three per triangle.
  };
  struct Instance {
    std::array<float, 12> pose;  ///< Column by column.
    Rgba color;
    std::array<float, 2> scales;  ///< Scales of bottom and top.
  };
  struct Kind {
    GlVertexArray vertices;
    GlBuffer corners, indices, instances;
    std::size_t steps = 0;  ///< Corners of a circle in the mesh; 0: no mesh yet.
    std::size_t mesh_bytes = 0, index_count = 0, opaque = 0, blended = 0;
  };
  /// `steps`: corners of a circle.
  static Mesh Cube(std::size_t steps);
  static Mesh Sphere(std::size_t steps);
  static Mesh Cylinder(std::size_t steps);
  static void SetMesh(Kind& kind, Mesh (*make)(std::size_t steps), std::size_t steps);
  static void Set(Kind& kind, Mesh (*make)(std::size_t steps), std::span<const SolidShape> shapes);

  ShaderProgram program_;
  std::array<Kind, 3> kinds_;
};

}  // namespace hgros::viewer
