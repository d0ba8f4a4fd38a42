#include "viewer/scene/layers/point_programs.hpp"

namespace hgros::viewer {
namespace {

constexpr const char* kPointVertex = R"(
#ifdef BY_CELL
layout(location = 0) in uint code;
layout(location = 1) in float value;
layout(location = 2) in uint rgb565;
uniform samplerBuffer pages;
uniform int stride;
uniform int first;
uniform float cell;
#else
layout(location = 0) in vec4 packed_point;
layout(location = 2) in vec4 rgba;
uniform vec3 box;
#endif
uniform mat4 clip_from_eye;
uniform vec3 origin_from_eye;
uniform int color_by;
uniform vec3 flat_color;
uniform vec3 axis;          // unit vector of the axis that sets the color
uniform vec2 axis_to_unit;  // scale, shift
uniform vec2 value_to_unit;
uniform float map_row;
uniform sampler2D maps;
uniform vec2 size;          // fixed pixels, pixels per meter at 1 m
uniform float perspective;
flat out vec3 color;

void main() {
#ifdef BY_CELL
  if (code == 0xFFFFFFFFu) {
    gl_Position = vec4(0, 0, 2, 1);
    gl_PointSize = 1.0;
    color = vec3(0);
    return;
  }
  int index = gl_VertexID * stride + first;
  vec3 at = texelFetch(pages, index / PAGE_POINTS).xyz +
      (vec3(code & 2047u, (code >> 11u) & 2047u, code >> 22u) + 0.5) * cell * vec3(1.0 / 2048, 1.0 / 2048, 1.0 / 1023);
  float stored = value;
#else
  vec3 at = packed_point.xyz * box;
  float stored = packed_point.w;
#endif
  gl_Position = clip_from_eye * vec4(origin_from_eye + at, 1);
  gl_PointSize = clamp(size.x + size.y / mix(1.0, gl_Position.w, perspective), 1.0, 64.0);
  if (color_by == 0) {
    color = flat_color;
  } else if (color_by == 3) {
#ifdef BY_CELL
    color = vec3(rgb565 >> 11u, (rgb565 >> 5u) & 63u, rgb565 & 31u) / vec3(31, 63, 31);
#else
    color = rgba.rgb;
#endif
  } else {
    float unit = color_by == 1 ? dot(at, axis) * axis_to_unit.x + axis_to_unit.y : stored * value_to_unit.x + value_to_unit.y;
    color = textureLod(maps, vec2((clamp(unit, 0.0, 1.0) * 255.0 + 0.5) / 256.0, map_row), 0.0).rgb;
  }
}
)";

constexpr const char* kPointFragment = R"(
flat in vec3 color;
out vec4 result;
void main() { result = vec4(color, 1); }
)";

}  // namespace

PointPrograms::PointPrograms()
    : by_cell_("points by cell", "#define BY_CELL\n#define PAGE_POINTS 256\n", kPointVertex, kPointFragment),
      by_message_("points by message", "", kPointVertex, kPointFragment) {}

GLuint PointPrograms::color_maps() {
  if (!maps_) {
    maps_ = GlTexture::New();
    const std::vector<std::uint8_t> table = ColorMapTable();
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D, maps_.name());
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, static_cast<GLsizei>(kColorMapSteps),
                 static_cast<GLsizei>(kColorMapNames.size()), 0, GL_RGB, GL_UNSIGNED_BYTE, table.data());
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  }
  return maps_.name();
}

ShaderProgram& PointPrograms::Begin(bool by_cell, const ViewMatrices& view, const PointStyle& style) {
  ShaderProgram& program = by_cell ? by_cell_ : by_message_;
  program.Use();
  const GLuint maps = color_maps();
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, maps);
  program.Set("maps", 0);
  program.Set("pages", 1);
  program.Set("clip_from_eye", view.clip_from_eye);
  program.Set("color_by", static_cast<int>(style.color_by));
  program.Set("flat_color", Eigen::Vector3f(style.flat[0], style.flat[1], style.flat[2]));
  program.Set("axis", Eigen::Vector3f(Eigen::Vector3f::Unit(style.axis)));
  program.Set("map_row", (static_cast<float>(style.map) + 0.5F) / static_cast<float>(kColorMapNames.size()));
  const float in_meters = style.size_in_meters ? style.size * view.pixels_per_meter_at_1m : 0;
  program.Set("size", Eigen::Vector2f(style.size_in_meters ? 0 : style.size, in_meters));
  program.Set("perspective", view.orthographic ? 0.0F : 1.0F);
  glEnable(GL_PROGRAM_POINT_SIZE);
  glEnable(GL_DEPTH_TEST);
  return program;
}

void PointPrograms::SetOrigin(ShaderProgram& program, const ViewMatrices& view, const PointStyle& style,
                              const Eigen::Vector3d& origin, double scalar_lo, double scalar_hi) {
  program.Set("origin_from_eye", Eigen::Vector3f((origin - view.eye).cast<float>()));
  const double spread = style.hi > style.lo ? style.hi - style.lo : 1;
  program.Set("axis_to_unit", Eigen::Vector2f(static_cast<float>(1 / spread),
                                              static_cast<float>((origin[style.axis] - style.lo) / spread)));
  program.Set("value_to_unit", Eigen::Vector2f(static_cast<float>((scalar_hi - scalar_lo) / spread),
                                               static_cast<float>((scalar_lo - style.lo) / spread)));
}

}  // namespace hgros::viewer
