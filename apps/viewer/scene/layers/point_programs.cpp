#include "viewer/scene/layers/point_programs.hpp"

namespace hgros::viewer {
namespace {

constexpr const char* kPointVertex = R"(
#ifdef BY_CELL
layout(location = 0) in uint code;
layout(location = 1) in float value;
layout(location = 2) in uint rgb565;
uniform samplerBuffer pages;  // corner and edge of each page's cell, then its lowest and highest value
uniform int stride;
uniform int first;
#else
layout(location = 0) in vec3 position;
layout(location = 1) in float value;
layout(location = 2) in vec4 rgba;
#endif
uniform mat4 clip_from_eye;
uniform vec3 origin_from_eye;
uniform mat3 turn;
uniform int color_by;
uniform vec3 flat_color;
uniform vec3 axis;          // unit vector of the axis that sets the color
uniform vec2 axis_to_unit;  // scale, shift
uniform vec2 value_to_unit; // lowest value, scale
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
  int page = (gl_VertexID * stride + first) / PAGE_POINTS;
  vec4 cell = texelFetch(pages, 2 * page);
  vec2 range = texelFetch(pages, 2 * page + 1).xy;
  vec3 in_cell = (vec3(code & 2047u, (code >> 11u) & 2047u, code >> 22u) + 0.5) / vec3(2048, 2048, 1023);
  vec3 at = turn * (cell.xyz + in_cell * cell.w);
  float shown = mix(range.x, range.y, value);
#else
  vec3 at = turn * position;
  float shown = value;
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
    float unit = (shown - value_to_unit.x) * value_to_unit.y;
    if (color_by == 1) unit = dot(at, axis) * axis_to_unit.x + axis_to_unit.y;
    unit = unit > 0.0 ? min(unit, 1.0) : 0.0;  // also if it is not a number
    color = textureLod(maps, vec2((unit * 255.0 + 0.5) / 256.0, map_row), 0.0).rgb;
  }
}
)";

constexpr const char* kPointFragment = R"(
flat in vec3 color;
out vec4 result;
void main() { result = vec4(color, 1); }
)";

double Spread(const PointStyle& style) { return style.hi > style.lo ? style.hi - style.lo : 1; }

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
  program.Set("value_to_unit", Eigen::Vector2f(static_cast<float>(style.lo), static_cast<float>(1 / Spread(style))));
  glEnable(GL_PROGRAM_POINT_SIZE);
  glEnable(GL_DEPTH_TEST);
  return program;
}

void PointPrograms::SetPlace(ShaderProgram& program, const ViewMatrices& view, const PointStyle& style,
                             const RigidTransform& T_fixed_points) {
  const Eigen::Vector3d& origin = T_fixed_points.translation;
  program.Set("origin_from_eye", Eigen::Vector3f((origin - view.eye).cast<float>()));
  program.Set("turn", Eigen::Matrix3f(T_fixed_points.rotation.toRotationMatrix().cast<float>()));
  const double spread = Spread(style);
  program.Set("axis_to_unit", Eigen::Vector2f(static_cast<float>(1 / spread),
                                              static_cast<float>((origin[style.axis] - style.lo) / spread)));
}

}  // namespace hgros::viewer
