#include "viewer/scene/gl/shaded_program.hpp"

namespace hgros::viewer::shaded_program {

std::string VertexSource(std::string_view kind) {
  return R"(
uniform mat4 clip_from_eye;
uniform vec3 origin_from_eye;
uniform vec4 turn;
out vec4 color;
out vec3 from_eye;
out vec3 facing;

vec3 Turned(vec4 by, vec3 v) { return v + 2.0 * cross(by.xyz, cross(by.xyz, v) + by.w * v); }

void Place(vec3 at, vec3 normal) {
  from_eye = origin_from_eye + Turned(turn, at);
  facing = Turned(turn, normal);
  gl_Position = clip_from_eye * vec4(from_eye, 1);
}
)" + std::string(kind);
}

std::string FragmentSource() {
  return R"(
in vec4 color;
in vec3 from_eye;
in vec3 facing;
uniform vec3 looks;  // viewing direction of an orthographic camera; length 0: perspective
out vec4 result;
void main() {
  vec3 normal = dot(facing, facing) > 1e-12 ? facing : cross(dFdx(from_eye), dFdy(from_eye));
  vec3 ray = dot(looks, looks) > 0.0 ? looks : from_eye;
  normal *= inversesqrt(max(dot(normal, normal), 1e-30));
  float to_eye = dot(normal, normalize(ray));
  float sky = to_eye > 0.0 ? -normal.z : normal.z;
  result = vec4(color.rgb * (0.42 + 0.4 * abs(to_eye) + 0.18 * sky), color.a);
}
)";
}

void Begin(ShaderProgram& program, const ViewMatrices& view, const RigidTransform& T_fixed_surface) {
  program.Use();
  program.Set("clip_from_eye", view.clip_from_eye);
  program.Set("origin_from_eye", Eigen::Vector3f((T_fixed_surface.translation - view.eye).cast<float>()));
  program.Set("turn", Eigen::Vector4f(T_fixed_surface.rotation.coeffs().cast<float>()));
  const Eigen::Vector3f deeper = view.clip_from_eye.row(2).head<3>();
  program.Set("looks", view.orthographic ? Eigen::Vector3f(deeper.normalized()) : Eigen::Vector3f(0, 0, 0));
  glEnable(GL_DEPTH_TEST);
}

void BeginBlending(bool marks_depth) {
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  glDepthMask(marks_depth ? GL_TRUE : GL_FALSE);
}

void EndBlending() {
  glDisable(GL_BLEND);
  glDepthMask(GL_TRUE);
}

}  // namespace hgros::viewer::shaded_program
