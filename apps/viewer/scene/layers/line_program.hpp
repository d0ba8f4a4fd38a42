#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>

#include "hgros/tf/rigid_transform.hpp"
#include "viewer/scene/gl/shader_program.hpp"
#include "viewer/view/camera.hpp"

namespace hgros::viewer {

/// Draws segments as quads with a width in pixels, because GL 3.3 does not guarantee wide lines. One instanced call
/// draws any number of segments.
namespace line_program {

/// A vertex shader around a `main` in GLSL, which sets `color` and can call `vec4 OnScreen(vec3 from, vec3 to, int
/// corner)`. That returns corner 0 to 5 of the segment's quad; both ends are in the frame given to Begin. With the
/// extra arguments `float width, float meters` a segment has its own width; `meters` is 1 for meters and 0 for pixels.
[[nodiscard]] std::string VertexSource(std::string_view kind);
[[nodiscard]] std::string FragmentSource();

/// Uses the program for lines in a frame with that transform to the fixed frame.
void Begin(ShaderProgram& program, const ViewMatrices& view, const RigidTransform& T_fixed_lines, float width_pixels);

}  // namespace line_program
}  // namespace hgros::viewer
