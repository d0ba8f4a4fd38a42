#include "viewer/scene/layers/voxel_cubes.hpp"

#include <algorithm>
#include <vector>

#include "viewer/scene/gl/shaded_program.hpp"

namespace hgros::viewer {
namespace {

constexpr const char* kCubeVertex = R"(
layout(location = 0) in uvec3 cell;
layout(location = 1) in uint faces;
layout(location = 2) in float value;
uniform vec3 cell_size;
uniform vec4 height_to_unit;  // of a point in the grid: factors, shift
uniform vec2 value_to_unit;
uniform int color_by;
uniform vec4 flat_color;
uniform float map_row;
uniform sampler2D maps;
out vec3 corner;
flat out uint open_faces;
out vec4 cube_color;
void main() {
  corner = vec3(cell) * cell_size;
  open_faces = faces;
  float unit = color_by == 1 ? dot(corner + 0.5 * cell_size, height_to_unit.xyz) + height_to_unit.w
                             : value * value_to_unit.x + value_to_unit.y;
  vec3 mapped = textureLod(maps, vec2((clamp(unit, 0.0, 1.0) * 255.0 + 0.5) / 256.0, map_row), 0.0).rgb;
  cube_color = vec4(color_by == 0 ? flat_color.rgb : mapped, flat_color.a);
}
)";

constexpr const char* kGeometry = R"(
layout(points) in;
layout(triangle_strip, max_vertices = 12) out;
in vec3 corner[];
flat in uint open_faces[];
in vec4 cube_color[];
uniform mat4 clip_from_eye;
uniform vec3 origin_from_eye;
uniform vec4 turn;
uniform vec3 cell_size;
uniform vec4 eye_in_grid;  // w = 0: the direction to it
out vec4 color;
out vec3 from_eye;
out vec3 facing;

vec3 Turned(vec4 by, vec3 v) { return v + 2.0 * cross(by.xyz, cross(by.xyz, v) + by.w * v); }

void Corner(vec3 at) {
  from_eye = origin_from_eye + Turned(turn, at);
  gl_Position = clip_from_eye * vec4(from_eye, 1);
  EmitVertex();
}

void main() {
  vec3 least = corner[0];
  vec3 most = least + cell_size;
  for (int axis = 0; axis < 3; ++axis) {
    bool above = eye_in_grid[axis] > eye_in_grid.w * most[axis];
    bool below = eye_in_grid[axis] < eye_in_grid.w * least[axis];
    uint face = uint(2 * axis + (above ? 1 : 0));
    if (!(above || below) || ((open_faces[0] >> face) & 1u) == 0u) continue;
    vec3 normal = vec3(0);
    normal[axis] = above ? 1.0 : -1.0;
    vec3 u = vec3(0);
    u[(axis + 1) % 3] = cell_size[(axis + 1) % 3];
    vec3 v = vec3(0);
    v[(axis + 2) % 3] = cell_size[(axis + 2) % 3];
    vec3 first = least;
    if (above) first[axis] = most[axis];
    color = cube_color[0];
    facing = Turned(turn, normal);
    Corner(first);
    color = cube_color[0];
    facing = Turned(turn, normal);
    Corner(first + u);
    color = cube_color[0];
    facing = Turned(turn, normal);
    Corner(first + v);
    color = cube_color[0];
    facing = Turned(turn, normal);
    Corner(first + u + v);
    EndPrimitive();
  }
}
)";

}  // namespace

VoxelCubes::VoxelCubes() : program_("voxels", "", kCubeVertex, shaded_program::FragmentSource(), kGeometry) {}

void VoxelCubes::Set(const VoxelPicture& voxels) {
  count_ = voxels.cubes.size();
  cell_size_ = voxels.cell_size;
  if (count_ == 0) return;
  std::vector<Cube> cubes;
  cubes.reserve(count_);
  for (const VoxelCube& cube : voxels.cubes) {
    const auto cell = [&](std::size_t axis) { return static_cast<std::uint16_t>(cube.cell[axis]); };
    cubes.push_back({{cell(0), cell(1), cell(2)}, cube.faces, cube.value});
  }
  if (!buffer_) {
    buffer_ = GlBuffer::New();
    vertices_ = GlVertexArray::New();
  }
  glBindBuffer(GL_ARRAY_BUFFER, buffer_.name());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(cubes.size() * sizeof(Cube)), cubes.data(), GL_STATIC_DRAW);
}

void VoxelCubes::Draw(const DrawContext& context, const RigidTransform& T_fixed_corner, const VoxelStyle& style,
                      const Slice& slice, bool blended) {
  if (count_ <= slice.index || style.alpha <= 0) return;
  const ViewMatrices& view = context.view;
  shaded_program::Begin(program_, view, T_fixed_corner);
  const RigidTransform::Rotation back = T_fixed_corner.rotation.conjugate();
  const Eigen::Vector3d to_eye = back * (view.eye - T_fixed_corner.translation);
  const Eigen::Vector3d deeper = view.clip_from_eye.row(2).head<3>().transpose().cast<double>();
  const Eigen::Vector3d direction = back * Eigen::Vector3d(-deeper);
  const Eigen::Vector3d eye = view.orthographic ? direction : to_eye;
  program_.Set("eye_in_grid", Eigen::Vector4f(static_cast<float>(eye.x()), static_cast<float>(eye.y()),
                                              static_cast<float>(eye.z()), view.orthographic ? 0.0F : 1.0F));
  program_.Set("cell_size", Eigen::Vector3f(cell_size_.cast<float>()));
  const double spread = style.hi > style.lo ? style.hi - style.lo : 1;
  const Eigen::Vector3d up = back * Eigen::Vector3d::UnitZ() / spread;
  program_.Set("height_to_unit",
               Eigen::Vector4f(static_cast<float>(up.x()), static_cast<float>(up.y()), static_cast<float>(up.z()),
                               static_cast<float>((T_fixed_corner.translation.z() - style.lo) / spread)));
  program_.Set("value_to_unit",
               Eigen::Vector2f(static_cast<float>(1 / spread), static_cast<float>(-style.lo / spread)));
  program_.Set("color_by", static_cast<int>(style.color_by));
  program_.Set("flat_color", Eigen::Vector4f(style.flat[0], style.flat[1], style.flat[2], style.alpha));
  program_.Set("map_row", (static_cast<float>(style.map) + 0.5F) / static_cast<float>(kColorMapNames.size()));
  program_.Set("maps", 0);
  const GLuint maps = context.points.color_maps();
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, maps);
  glBindVertexArray(vertices_.name());
  glBindBuffer(GL_ARRAY_BUFFER, buffer_.name());
  const auto stride = static_cast<GLsizei>(slice.count * sizeof(Cube));
  const std::size_t base = slice.index * sizeof(Cube);
  for (GLuint i = 0; i < 3; ++i) glEnableVertexAttribArray(i);
  const auto at = [&](std::size_t offset) {
    return reinterpret_cast<const void*>(base + offset);  // NOLINT: as GL wants it
  };
  glVertexAttribIPointer(0, 3, GL_UNSIGNED_SHORT, stride, at(offsetof(Cube, cell)));
  glVertexAttribIPointer(1, 1, GL_UNSIGNED_SHORT, stride, at(offsetof(Cube, faces)));
  glVertexAttribPointer(2, 1, GL_FLOAT, GL_FALSE, stride, at(offsetof(Cube, value)));
  if (blended) shaded_program::BeginBlending(context.marks_depth);
  const std::size_t count = (count_ - slice.index + slice.count - 1) / slice.count;
  for (std::size_t first = 0; first < count; first += DrawnPoints::kAtOnce) {
    const std::size_t part = std::min(DrawnPoints::kAtOnce, count - first);
    glDrawArrays(GL_POINTS, static_cast<GLint>(first), static_cast<GLsizei>(part));
    drawn_.Count(part);
  }
  if (blended) shaded_program::EndBlending();
}

}  // namespace hgros::viewer
