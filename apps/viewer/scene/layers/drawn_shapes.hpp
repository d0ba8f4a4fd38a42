#pragma once

#include <cstddef>

#include "viewer/data/shapes/scene_shapes.hpp"
#include "viewer/scene/display.hpp"
#include "viewer/scene/layers/line_pieces.hpp"
#include "viewer/scene/layers/solids.hpp"
#include "viewer/scene/layers/triangles.hpp"

namespace hgros::viewer {

/// Shapes on the GPU, without texts and models.
class DrawnShapes {
 public:
  /// Positions are in the frame given when they are drawn.
  void Set(const SceneShapes& shapes) {
    solids_.Set(shapes);
    lines_.Set(shapes.lines);
    triangles_.Set(shapes.triangles);
  }
  /// Draws the opaque ones, or the transparent ones, which must come later.
  void Draw(const DrawContext& context, const RigidTransform& T_fixed_shapes, bool blended) {
    solids_.Draw(context, T_fixed_shapes, blended);
    triangles_.Draw(context, T_fixed_shapes, blended);
    lines_.Draw(context, T_fixed_shapes, blended);
  }
  [[nodiscard]] std::size_t gpu_bytes() const noexcept {
    return solids_.gpu_bytes() + lines_.gpu_bytes() + triangles_.gpu_bytes();
  }

 private:
  Solids solids_;
  LinePieces lines_;
  Triangles triangles_;
};

}  // namespace hgros::viewer
