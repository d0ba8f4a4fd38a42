#include "viewer/scene/solids.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "viewer/scene/shaded_program.hpp"

namespace hgros::viewer {
namespace {

constexpr const char* kVertex = R"(
layout(location = 0) in vec3 corner;
layout(location = 1) in vec3 corner_normal;
layout(location = 2) in vec3 pose_x;
layout(location = 3) in vec3 pose_y;
layout(location = 4) in vec3 pose_z;
layout(location = 5) in vec3 pose_at;
layout(location = 6) in vec4 solid_color;
layout(location = 7) in vec2 scales;
void main() {
  vec3 at = vec3(corner.xy * mix(scales.x, scales.y, corner.z + 0.5), corner.z);
  vec3 normal = corner_normal;
  if (normal.z * normal.z < 1.0 && scales.x != scales.y) normal.z = 0.5 * (scales.x - scales.y);
  mat3 normals = mat3(cross(pose_y, pose_z), cross(pose_z, pose_x), cross(pose_x, pose_y));
  vec3 turned = normals * normal;
  float size = length(turned);
  Place(mat3(pose_x, pose_y, pose_z) * at + pose_at, size > 0.0 ? turned / size : vec3(0, 0, 1));
  color = solid_color;
}
)";

constexpr std::size_t kRound = 28;  ///< Corners of a circle.

/// Floats, or the 4 bytes of a colour.
void Attribute(GLuint at, GLint size, std::size_t stride, std::size_t offset, GLuint divisor) {
  const bool is_color = size == 4;
  glEnableVertexAttribArray(at);
  glVertexAttribDivisor(at, divisor);
  glVertexAttribPointer(at, size, is_color ? GL_UNSIGNED_BYTE : GL_FLOAT, is_color ? GL_TRUE : GL_FALSE,
                        static_cast<GLsizei>(stride), reinterpret_cast<const void*>(offset));  // NOLINT: as GL wants it
}

}  // namespace

Solids::Solids() : program_("solids", "", shaded_program::VertexSource(kVertex), shaded_program::FragmentSource()) {}

std::vector<Solids::Corner> Solids::Cube() {
  std::vector<Corner> corners;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const float side : {-0.5F, 0.5F}) {
      for (const auto& [u, v] : std::array<std::array<float, 2>, 6>{
               {{-0.5F, -0.5F}, {0.5F, -0.5F}, {0.5F, 0.5F}, {-0.5F, -0.5F}, {0.5F, 0.5F}, {-0.5F, 0.5F}}}) {
        Corner corner{};
        corner.at[axis] = side;
        corner.at[(axis + 1) % 3] = u;
        corner.at[(axis + 2) % 3] = v;
        corner.normal[axis] = 2 * side;
        corners.push_back(corner);
      }
    }
  }
  return corners;
}

std::vector<Solids::Corner> Solids::Sphere() {
  constexpr std::size_t kRings = 14;
  const auto at = [](std::size_t ring, std::size_t step) {
    const double down = std::numbers::pi * static_cast<double>(ring) / kRings;
    const double around = 2 * std::numbers::pi * static_cast<double>(step) / kRound;
    Corner corner{};
    corner.normal = {static_cast<float>(std::sin(down) * std::cos(around)),
                     static_cast<float>(std::sin(down) * std::sin(around)), static_cast<float>(std::cos(down))};
    for (std::size_t i = 0; i < 3; ++i) corner.at[i] = 0.5F * corner.normal[i];
    return corner;
  };
  std::vector<Corner> corners;
  for (std::size_t ring = 0; ring < kRings; ++ring) {
    for (std::size_t step = 0; step < kRound; ++step) {
      if (ring > 0) corners.insert(corners.end(), {at(ring, step), at(ring + 1, step), at(ring, step + 1)});
      if (ring + 1 < kRings) {
        corners.insert(corners.end(), {at(ring + 1, step), at(ring + 1, step + 1), at(ring, step + 1)});
      }
    }
  }
  return corners;
}

std::vector<Solids::Corner> Solids::Cylinder() {
  std::vector<Corner> corners;
  for (std::size_t step = 0; step < kRound; ++step) {
    const auto around = [](std::size_t i) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(i) / kRound;
      return std::array<float, 2>{static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))};
    };
    const auto from = around(step);
    const auto to = around(step + 1);
    const auto side = [](const std::array<float, 2>& out, float z) {
      return Corner{{0.5F * out[0], 0.5F * out[1], z}, {out[0], out[1], 0}};
    };
    corners.insert(corners.end(), {side(from, -0.5F), side(to, -0.5F), side(to, 0.5F)});
    corners.insert(corners.end(), {side(from, -0.5F), side(to, 0.5F), side(from, 0.5F)});
    for (const float z : {-0.5F, 0.5F}) {
      const auto cap = [z](float x, float y) { return Corner{{0.5F * x, 0.5F * y, z}, {0, 0, 2 * z}}; };
      corners.insert(corners.end(), {cap(0, 0), cap(from[0], from[1]), cap(to[0], to[1])});
    }
  }
  return corners;
}

void Solids::Set(const SceneShapes& shapes) {
  Set(kinds_[0], Cube, shapes.cubes);
  Set(kinds_[1], Sphere, shapes.spheres);
  Set(kinds_[2], Cylinder, shapes.cylinders);
}

void Solids::Set(Kind& kind, std::vector<Corner> (*mesh)(), std::span<const SolidShape> shapes) {
  kind.opaque = kind.blended = 0;
  if (shapes.empty()) return;
  if (!kind.mesh) {
    kind.vertices = GlVertexArray::New();
    kind.mesh = GlBuffer::New();
    kind.instances = GlBuffer::New();
    const std::vector<Corner> corners = mesh();
    kind.corners = corners.size();
    glBindVertexArray(kind.vertices.name());
    glBindBuffer(GL_ARRAY_BUFFER, kind.mesh.name());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(corners.size() * sizeof(Corner)), corners.data(),
                 GL_STATIC_DRAW);
    Attribute(0, 3, sizeof(Corner), offsetof(Corner, at), 0);
    Attribute(1, 3, sizeof(Corner), offsetof(Corner, normal), 0);
  }
  std::vector<Instance> instances;
  instances.reserve(shapes.size());
  for (const bool blended : {false, true}) {
    for (const SolidShape& shape : shapes) {
      if ((AlphaOf(shape.color) < 255) != blended || AlphaOf(shape.color) == 0) continue;
      Instance& instance = instances.emplace_back();
      const Eigen::Matrix<float, 3, 4> pose = shape.pose.cast<float>();
      std::copy_n(pose.data(), 12, instance.pose.begin());
      instance.color = shape.color;
      instance.scales = {shape.bottom_scale, shape.top_scale};
    }
    (blended ? kind.blended : kind.opaque) = instances.size() - (blended ? kind.opaque : 0);
  }
  glBindBuffer(GL_ARRAY_BUFFER, kind.instances.name());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(instances.size() * sizeof(Instance)), instances.data(),
               GL_DYNAMIC_DRAW);
}

void Solids::Draw(const ViewMatrices& view, const RigidTransform& T_fixed_shapes, bool blended) {
  for (Kind& kind : kinds_) {
    const std::size_t count = blended ? kind.blended : kind.opaque;
    if (count == 0) continue;
    shaded_program::Begin(program_, view, T_fixed_shapes);
    glBindVertexArray(kind.vertices.name());
    glBindBuffer(GL_ARRAY_BUFFER, kind.instances.name());
    const std::size_t first = blended ? kind.opaque * sizeof(Instance) : 0;
    for (GLuint column = 0; column < 4; ++column) {
      Attribute(2 + column, 3, sizeof(Instance), first + offsetof(Instance, pose) + 12 * column, 1);
    }
    Attribute(6, 4, sizeof(Instance), first + offsetof(Instance, color), 1);
    Attribute(7, 2, sizeof(Instance), first + offsetof(Instance, scales), 1);
    if (blended) shaded_program::BeginBlending();
    glDrawArraysInstanced(GL_TRIANGLES, 0, static_cast<GLsizei>(kind.corners), static_cast<GLsizei>(count));
    if (blended) shaded_program::EndBlending();
  }
}

std::size_t Solids::gpu_bytes() const noexcept {
  std::size_t bytes = 0;
  for (const Kind& kind : kinds_) {
    bytes += kind.corners * sizeof(Corner) + (kind.opaque + kind.blended) * sizeof(Instance);
  }
  return bytes;
}

}  // namespace hgros::viewer
