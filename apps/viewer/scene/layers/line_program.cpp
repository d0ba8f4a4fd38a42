#include "viewer/scene/layers/line_program.hpp"

namespace hgros::viewer::line_program {

std::string VertexSource(std::string_view kind) {
  return R"(
uniform mat4 clip_from_eye;
uniform vec3 origin_from_eye;
uniform vec4 turn;
uniform vec2 half_viewport;
uniform float line_width;
uniform float pixels_per_meter;
flat out vec4 color;

vec3 Turned(vec4 by, vec3 v) { return v + 2.0 * cross(by.xyz, cross(by.xyz, v) + by.w * v); }

// Widths in pixels, or in meters if `meters` is 1.
vec4 OnScreen(vec3 from, vec3 to, int corner, float width, float meters) {
  vec4 a = clip_from_eye * vec4(origin_from_eye + Turned(turn, from), 1);
  vec4 b = clip_from_eye * vec4(origin_from_eye + Turned(turn, to), 1);
  // Cut off what is behind the near plane: it would appear upside down.
  float near_a = a.z + a.w;
  float near_b = b.z + b.w;
  if (near_a <= 0.0 && near_b <= 0.0) return vec4(0, 0, 2, 1);
  if (near_a < 0.0) a = mix(a, b, near_a / (near_a - near_b));
  if (near_b < 0.0) b = mix(b, a, near_b / (near_b - near_a));
  vec2 along = (b.xy / b.w - a.xy / a.w) * half_viewport;
  float size = length(along);
  bool is_point = size < 1e-4;
  along = is_point ? vec2(1, 0) : along / size;
  bool at_b = corner == 1 || corner == 2 || corner == 4;
  float side = corner == 0 || corner == 1 || corner == 3 ? -1.0 : 1.0;
  vec4 end = at_b ? b : a;
  float half_width = 0.5 * mix(width, max(1.0, width * pixels_per_meter / end.w), meters);
  float cap = (at_b ? 1.0 : -1.0) * (is_point ? 1.0 : 0.5);
  vec2 shift = (side * vec2(-along.y, along.x) + cap * along) * half_width;
  return end + vec4(shift / half_viewport * end.w, 0, 0);
}
vec4 OnScreen(vec3 from, vec3 to, int corner) { return OnScreen(from, to, corner, line_width, 0.0); }
)" + std::string(kind);
}

std::string FragmentSource() {
  return R"(
flat in vec4 color;
out vec4 result;
void main() { result = color; }
)";
}

void Begin(ShaderProgram& program, const ViewMatrices& view, const RigidTransform& T_fixed_lines, float width_pixels) {
  program.Use();
  program.Set("clip_from_eye", view.clip_from_eye);
  program.Set("origin_from_eye", Eigen::Vector3f((T_fixed_lines.translation - view.eye).cast<float>()));
  program.Set("turn", Eigen::Vector4f(T_fixed_lines.rotation.coeffs().cast<float>()));
  program.Set("half_viewport", Eigen::Vector2f(0.5F * static_cast<float>(view.viewport.width),
                                               0.5F * static_cast<float>(view.viewport.height)));
  program.Set("line_width", width_pixels);
  program.Set("pixels_per_meter", view.pixels_per_meter_at_1m);
  glEnable(GL_DEPTH_TEST);
}

}  // namespace hgros::viewer::line_program
