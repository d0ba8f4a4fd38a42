#pragma once

#include <cstddef>

#include "viewer/data/scene_shapes.hpp"
#include "viewer/scene/display.hpp"
#include "viewer/scene/line_pieces.hpp"
#include "viewer/scene/solids.hpp"
#include "viewer/scene/triangles.hpp"

namespace hgros::viewer {

/// Shapes as the GPU has them; texts and models are not drawn here.
class DrawnShapes {
 public:
  /// Positions are in the frame that they are drawn with.
  void Set(const SceneShapes& shapes) {
    solids_.Set(shapes);
    lines_.Set(shapes.lines);
    triangles_.Set(shapes.triangles);
  }
  /// Those that hide what is behind them, or the others, which are to be drawn later.
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
