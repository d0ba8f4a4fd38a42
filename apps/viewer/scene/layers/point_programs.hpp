#pragma once

#include "hgros/tf/rigid_transform.hpp"
#include "viewer/scene/gl/gl_object.hpp"
#include "viewer/scene/gl/shader_program.hpp"
#include "viewer/scene/layers/point_style.hpp"
#include "viewer/view/camera.hpp"

namespace hgros::viewer {

/// The shaders that draw points: one for those packed by cell (KeptPoints), one for those of a message (RecentPoints).
/// Both compute the color from position, value or stored color.
class PointPrograms {
 public:
  PointPrograms();

  ShaderProgram& Begin(bool by_cell, const ViewMatrices& view, const PointStyle& style);
  /// Prepares the program for points with that place in the fixed frame.
  void SetPlace(ShaderProgram& program, const ViewMatrices& view, const PointStyle& style,
                const RigidTransform& T_fixed_points);

  /// All color maps of ColorMapTable, one row each.
  [[nodiscard]] GLuint color_maps();

 private:
  ShaderProgram by_cell_;
  ShaderProgram by_message_;
  GlTexture maps_;
};

}  // namespace hgros::viewer
