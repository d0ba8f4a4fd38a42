#include "viewer/scene/layers/solids.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "viewer/scene/gl/shaded_program.hpp"

namespace hgros::viewer {
namespace {

constexpr const char* kSolidVertex = R"(
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

// Corners of a circle: fine for few shapes, coarse for many, which are small on the screen.
constexpr std::size_t kFine = 28;
constexpr std::size_t kCoarse = 14;
constexpr std::size_t kMostFine = 200;

/// `size` floats; 4 means the four bytes of a color.
void Attribute(GLuint at, GLint size, std::size_t stride, std::size_t offset, GLuint divisor) {
  const bool is_color = size == 4;
  glEnableVertexAttribArray(at);
  glVertexAttribDivisor(at, divisor);
  glVertexAttribPointer(at, size, is_color ? GL_UNSIGNED_BYTE : GL_FLOAT, is_color ? GL_TRUE : GL_FALSE,
                        static_cast<GLsizei>(stride), reinterpret_cast<const void*>(offset));  // NOLINT: as GL wants it
}

}  // namespace

Solids::Solids()
    : program_("solids", "", shaded_program::VertexSource(kSolidVertex), shaded_program::FragmentSource()) {}

Solids::Mesh Solids::Cube(std::size_t /*steps*/) {
  Mesh mesh;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const float side : {-0.5F, 0.5F}) {
      const auto first = static_cast<std::uint16_t>(mesh.corners.size());
      for (const auto& [u, v] :
           std::array<std::array<float, 2>, 4>{{{-0.5F, -0.5F}, {0.5F, -0.5F}, {0.5F, 0.5F}, {-0.5F, 0.5F}}}) {
        Corner corner{};
        corner.at[axis] = side;
        corner.at[(axis + 1) % 3] = u;
        corner.at[(axis + 2) % 3] = v;
        corner.normal[axis] = 2 * side;
        mesh.corners.push_back(corner);
      }
      const auto outward = side > 0 ? std::array<int, 6>{0, 1, 2, 0, 2, 3} : std::array<int, 6>{0, 2, 1, 0, 3, 2};
      for (const int index : outward) mesh.indices.push_back(static_cast<std::uint16_t>(first + index));
    }
  }
  return mesh;
}

Solids::Mesh Solids::Sphere(std::size_t steps) {
  const std::size_t rings = steps / 2;
  Mesh mesh;
  for (std::size_t ring = 0; ring <= rings; ++ring) {
    for (std::size_t step = 0; step <= steps; ++step) {
      const double down = std::numbers::pi * static_cast<double>(ring) / static_cast<double>(rings);
      const double around = 2 * std::numbers::pi * static_cast<double>(step) / static_cast<double>(steps);
      Corner& corner = mesh.corners.emplace_back();
      corner.normal = {static_cast<float>(std::sin(down) * std::cos(around)),
                       static_cast<float>(std::sin(down) * std::sin(around)), static_cast<float>(std::cos(down))};
      for (std::size_t i = 0; i < 3; ++i) corner.at[i] = 0.5F * corner.normal[i];
    }
  }
  const std::size_t row = steps + 1;
  for (std::size_t ring = 0; ring < rings; ++ring) {
    for (std::size_t step = 0; step < steps; ++step) {
      const std::size_t at = ring * row + step;
      for (const std::size_t index : {at, at + row, at + 1, at + row, at + row + 1, at + 1}) {
        mesh.indices.push_back(static_cast<std::uint16_t>(index));
      }
    }
  }
  return mesh;
}

Solids::Mesh Solids::Cylinder(std::size_t steps) {
  Mesh mesh;
  // The side, and the two caps with different normals.
  for (const float cap : {0.0F, -0.5F, 0.5F}) {
    const auto first = static_cast<std::uint16_t>(mesh.corners.size());
    for (std::size_t step = 0; step <= steps; ++step) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(step) / static_cast<double>(steps);
      const std::array<float, 2> out = {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))};
      for (const float z : {-0.5F, 0.5F}) {
        if (cap == 0) {
          mesh.corners.push_back({{0.5F * out[0], 0.5F * out[1], z}, {out[0], out[1], 0}});
        } else if (z == cap) {
          mesh.corners.push_back({{0.5F * out[0], 0.5F * out[1], z}, {0, 0, 2 * z}});
        }
      }
      if (step == 0) continue;
      const auto at = static_cast<std::uint16_t>(first + (cap == 0 ? 2 * step : step));
      const auto add = [&](int a, int b, int c) {
        for (const int index : {a, b, c}) mesh.indices.push_back(static_cast<std::uint16_t>(index));
      };
      if (cap != 0) {
        add(first, cap > 0 ? at - 1 : at, cap > 0 ? at : at - 1);
      } else {
        add(at - 2, at, at + 1);
        add(at - 2, at + 1, at - 1);
      }
    }
  }
  return mesh;
}

void Solids::Set(const SceneShapes& shapes) {
  Set(kinds_[0], Cube, shapes.cubes);
  Set(kinds_[1], Sphere, shapes.spheres);
  Set(kinds_[2], Cylinder, shapes.cylinders);
}

void Solids::SetMesh(Kind& kind, Mesh (*make)(std::size_t steps), std::size_t steps) {
  if (!kind.corners) {
    kind.vertices = GlVertexArray::New();
    kind.corners = GlBuffer::New();
    kind.indices = GlBuffer::New();
    kind.instances = GlBuffer::New();
  }
  kind.steps = steps;
  const Mesh mesh = make(steps);
  const auto bytes = [](const auto& list) { return static_cast<GLsizeiptr>(list.size() * sizeof(list[0])); };
  kind.index_count = mesh.indices.size();
  kind.mesh_bytes = static_cast<std::size_t>(bytes(mesh.corners) + bytes(mesh.indices));
  glBindVertexArray(kind.vertices.name());
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, kind.indices.name());
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, bytes(mesh.indices), mesh.indices.data(), GL_STATIC_DRAW);
  glBindBuffer(GL_ARRAY_BUFFER, kind.corners.name());
  glBufferData(GL_ARRAY_BUFFER, bytes(mesh.corners), mesh.corners.data(), GL_STATIC_DRAW);
  Attribute(0, 3, sizeof(Corner), offsetof(Corner, at), 0);
  Attribute(1, 3, sizeof(Corner), offsetof(Corner, normal), 0);
}

void Solids::Set(Kind& kind, Mesh (*make)(std::size_t steps), std::span<const SolidShape> shapes) {
  kind.opaque = kind.blended = 0;
  if (shapes.empty()) return;
  const std::size_t steps = shapes.size() <= kMostFine ? kFine : kCoarse;
  if (kind.steps != steps) SetMesh(kind, make, steps);
  std::vector<Instance> instances;
  instances.reserve(shapes.size());
  for (const bool blended : {false, true}) {
    for (const SolidShape& shape : shapes) {
      if ((AlphaOf(shape.color) < 255) != blended || IsInvisible(shape)) continue;
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

void Solids::Draw(const DrawContext& context, const RigidTransform& T_fixed_shapes, bool blended) {
  for (Kind& kind : kinds_) {
    const std::size_t count = blended ? kind.blended : kind.opaque;
    if (count == 0) continue;
    shaded_program::Begin(program_, context.view, T_fixed_shapes);
    glBindVertexArray(kind.vertices.name());
    glBindBuffer(GL_ARRAY_BUFFER, kind.instances.name());
    const std::size_t first = blended ? kind.opaque * sizeof(Instance) : 0;
    for (GLuint column = 0; column < 4; ++column) {
      Attribute(2 + column, 3, sizeof(Instance), first + offsetof(Instance, pose) + 12 * column, 1);
    }
    Attribute(6, 4, sizeof(Instance), first + offsetof(Instance, color), 1);
    Attribute(7, 2, sizeof(Instance), first + offsetof(Instance, scales), 1);
    if (blended) {  // The inside of transparent shapes is not drawn.
      shaded_program::BeginBlending(context.marks_depth);
      glEnable(GL_CULL_FACE);
    }
    glDrawElementsInstanced(GL_TRIANGLES, static_cast<GLsizei>(kind.index_count), GL_UNSIGNED_SHORT, nullptr,
                            static_cast<GLsizei>(count));
    if (blended) shaded_program::EndBlending();
    glDisable(GL_CULL_FACE);
  }
}

std::size_t Solids::gpu_bytes() const noexcept {
  std::size_t bytes = 0;
  for (const Kind& kind : kinds_) {
    bytes += kind.mesh_bytes + (kind.opaque + kind.blended) * sizeof(Instance);
  }
  return bytes;
}

}  // namespace hgros::viewer
