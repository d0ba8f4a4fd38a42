#pragma once

#include <Eigen/Core>

#include "viewer/scene/gl_object.hpp"
#include "viewer/scene/point_style.hpp"
#include "viewer/scene/shader_program.hpp"
#include "viewer/view/camera.hpp"

namespace hgros::viewer {

/// The shaders that draw points: one for those packed by cell (PageBook), one for those packed by message
/// (PackedPoints). Both compute the colour from position, value or stored colour.
class PointPrograms {
 public:
  PointPrograms();

  /// Makes the program ready for points around `origin` (in the fixed frame), whose values are stored as 0 to 1 for
  /// `scalar_lo` to `scalar_hi`.
  ShaderProgram& Begin(bool by_cell, const ViewMatrices& view, const PointStyle& style);
  void SetOrigin(ShaderProgram& program, const ViewMatrices& view, const PointStyle& style,
                 const Eigen::Vector3d& origin, double scalar_lo, double scalar_hi);

  /// All colour maps, a row for each: ColorMapTable.
  [[nodiscard]] GLuint color_maps();

 private:
  ShaderProgram by_cell_;
  ShaderProgram by_message_;
  GlTexture maps_;
};

}  // namespace hgros::viewer
