#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "viewer/data/shapes/scene_shapes.hpp"
#include "viewer/scene/display.hpp"
#include "viewer/scene/gl/gl_object.hpp"
#include "viewer/scene/gl/shader_program.hpp"

namespace hgros::viewer {

/// Triangles, lit by their own normals, all in one draw call. Thread: the one whose GL context is current.
class Triangles {
 public:
  Triangles();
  /// Three corners each. Positions are in the frame given when they are drawn.
  void Set(std::span<const TriangleCorner> corners);
  /// Draws the opaque ones, or the transparent ones, which must come later.
  void Draw(const DrawContext& context, const RigidTransform& T_fixed_triangles, bool blended);
  [[nodiscard]] std::size_t gpu_bytes() const noexcept { return (opaque_ + blended_) * sizeof(Corner); }

 private:
  struct Corner {
    std::array<float, 3> at;
    Rgba color;
  };

  ShaderProgram program_;
  GlBuffer buffer_;
  GlVertexArray vertices_;
  std::size_t opaque_ = 0, blended_ = 0;  ///< Corners.
};

}  // namespace hgros::viewer
