#pragma once

#include <string>
#include <string_view>

#include "hgros/tf/rigid_transform.hpp"
#include "viewer/scene/gl/shader_program.hpp"
#include "viewer/view/camera.hpp"

namespace hgros::viewer {

/// Draws surfaces lit by a lamp at the eye and by the sky. Both sides of a surface look the same.
namespace shaded_program {

/// A vertex shader around a `main` in GLSL, which calls `Place(vec3 at, vec3 normal)`, both in the frame given to
/// Begin, and sets `color`. With a normal of length 0, the triangle's own normal is used.
[[nodiscard]] std::string VertexSource(std::string_view kind);
[[nodiscard]] std::string FragmentSource();

/// Uses the program for surfaces in a frame with that transform to the fixed frame.
void Begin(ShaderProgram& program, const ViewMatrices& view, const RigidTransform& T_fixed_surface);

/// From here on, drawing is blended with what is behind it, and hides nothing unless it `marks_depth`.
void BeginBlending(bool marks_depth);
void EndBlending();

}  // namespace shaded_program
}  // namespace hgros::viewer
