#pragma once

#include <Eigen/Core>

#include "viewer/scene/gl/gl_object.hpp"
#include "viewer/scene/gl/shader_program.hpp"
#include "viewer/scene/layers/point_style.hpp"
#include "viewer/view/camera.hpp"

namespace hgros::viewer {

/// The shaders that draw points: one for those packed by cell (PageBook), one for those packed by message
/// (PackedPoints). Both compute the color from position, value or stored color.
class PointPrograms {
 public:
  PointPrograms();

  /// Prepares the program for points around `origin` (in the fixed frame), whose stored values 0 to 1 mean `scalar_lo`
  /// to `scalar_hi`.
  ShaderProgram& Begin(bool by_cell, const ViewMatrices& view, const PointStyle& style);
  void SetOrigin(ShaderProgram& program, const ViewMatrices& view, const PointStyle& style,
                 const Eigen::Vector3d& origin, double scalar_lo, double scalar_hi);

  /// All color maps of ColorMapTable, one row each.
  [[nodiscard]] GLuint color_maps();

 private:
  ShaderProgram by_cell_;
  ShaderProgram by_message_;
  GlTexture maps_;
};

}  // namespace hgros::viewer
