#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "viewer/data/scene_shapes.hpp"
#include "viewer/scene/display.hpp"
#include "viewer/scene/gl_object.hpp"
#include "viewer/scene/shader_program.hpp"

namespace hgros::viewer {

/// Triangles, lit as they lie, all in one draw call. Thread: the one whose GL context is current.
class Triangles {
 public:
  Triangles();
  /// Three corners each; positions are in the frame that they are drawn with.
  void Set(std::span<const TriangleCorner> corners);
  /// Those that hide what is behind them, or the others, which are to be drawn later.
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
