#pragma once

#include <string>
#include <string_view>

#include "hgros/tf/rigid_transform.hpp"
#include "viewer/scene/shader_program.hpp"
#include "viewer/view/camera.hpp"

namespace hgros::viewer {

/// Draws surfaces in the light of a lamp at the eye and of the sky. Both sides of a surface are alike.
namespace shaded_program {

/// A vertex shader around a `main` in GLSL, which calls `Place(vec3 at, vec3 normal)`, both in the frame that Begin was
/// told, and sets `color`. A normal of length 0: as the triangle lies.
[[nodiscard]] std::string VertexSource(std::string_view kind);
[[nodiscard]] std::string FragmentSource();

/// Uses the program for surfaces in a frame that lies so in the fixed one.
void Begin(ShaderProgram& program, const ViewMatrices& view, const RigidTransform& T_fixed_surface);

/// What is drawn from here on is mixed with what is behind it, and hides nothing unless it `marks_depth`.
void BeginBlending(bool marks_depth);
void EndBlending();

}  // namespace shaded_program
}  // namespace hgros::viewer
