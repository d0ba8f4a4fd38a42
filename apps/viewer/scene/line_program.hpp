#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>

#include "hgros/tf/rigid_transform.hpp"
#include "viewer/scene/shader_program.hpp"
#include "viewer/view/camera.hpp"

namespace hgros::viewer {

/// Draws segments as quads of a width in pixels, which GL 3.3 itself does not promise. One instanced call draws any
/// number of them.
namespace line_program {

/// A vertex shader around a `main` in GLSL, which has `vec4 OnScreen(vec3 from, vec3 to, int corner)`: the corner 0 to
/// 5 of the segment's quad, both ends in the frame that Begin was told; and sets `color`. With two more arguments a
/// segment has a width of its own: `float width, float metres`, the last 1 for metres and 0 for pixels.
[[nodiscard]] std::string VertexSource(std::string_view kind);
[[nodiscard]] std::string FragmentSource();

/// Uses the program for lines in a frame that lies so in the fixed one.
void Begin(ShaderProgram& program, const ViewMatrices& view, const RigidTransform& T_fixed_lines, float width_pixels);

}  // namespace line_program
}  // namespace hgros::viewer
