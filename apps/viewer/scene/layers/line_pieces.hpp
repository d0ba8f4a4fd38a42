#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "viewer/data/shapes/scene_shapes.hpp"
#include "viewer/scene/display.hpp"
#include "viewer/scene/gl/gl_object.hpp"
#include "viewer/scene/gl/shader_program.hpp"

namespace hgros::viewer {

/// Straight lines, each with a color at either end and its own width, all in one draw call. Thread: the one whose GL
/// context is current.
class LinePieces {
 public:
  LinePieces();
  /// Positions are in the frame given when they are drawn.
  void Set(std::span<const LinePiece> pieces);
  /// Draws the opaque ones, or the transparent ones, which must come later.
  void Draw(const DrawContext& context, const RigidTransform& T_fixed_lines, bool blended);
  [[nodiscard]] std::size_t gpu_bytes() const noexcept { return (opaque_ + blended_) * sizeof(Instance); }

 private:
  struct Instance {
    std::array<float, 3> from, to;
    Rgba from_color, to_color;
    std::array<float, 2> width;  ///< The width, and 1 if it is in meters.
  };

  ShaderProgram program_;
  GlBuffer buffer_;
  GlVertexArray vertices_;
  std::size_t opaque_ = 0, blended_ = 0;
};

}  // namespace hgros::viewer
