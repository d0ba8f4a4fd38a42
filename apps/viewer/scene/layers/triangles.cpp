#include "viewer/scene/layers/triangles.hpp"

#include <algorithm>
#include <vector>

#include "viewer/scene/gl/shaded_program.hpp"

namespace hgros::viewer {
namespace {

constexpr const char* kTriangleVertex = R"(
layout(location = 0) in vec3 corner;
layout(location = 1) in vec4 corner_color;
void main() {
  Place(corner, vec3(0));
  color = corner_color;
}
)";

}  // namespace

Triangles::Triangles()
    : program_("triangles", "", shaded_program::VertexSource(kTriangleVertex), shaded_program::FragmentSource()) {}

void Triangles::Set(std::span<const TriangleCorner> corners) {
  opaque_ = blended_ = 0;
  if (corners.empty()) return;
  std::vector<Corner> packed;
  packed.reserve(corners.size());
  for (const bool blended : {false, true}) {
    for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
      const auto triangle = corners.subspan(i).first<3>();
      const bool is_blended = std::ranges::any_of(triangle, [](const auto& at) { return AlphaOf(at.color) < 255; });
      if (is_blended != blended || IsInvisible(triangle)) continue;
      for (const TriangleCorner& corner : triangle) {
        const Eigen::Vector3f at = corner.position.cast<float>();
        packed.push_back({{at.x(), at.y(), at.z()}, corner.color});
      }
    }
    (blended ? blended_ : opaque_) = packed.size() - opaque_;
  }
  if (!buffer_) {
    buffer_ = GlBuffer::New();
    vertices_ = GlVertexArray::New();
    glBindVertexArray(vertices_.name());
    glBindBuffer(GL_ARRAY_BUFFER, buffer_.name());
    glEnableVertexAttribArray(0);
    glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(Corner), nullptr);
    glEnableVertexAttribArray(1);
    glVertexAttribPointer(1, 4, GL_UNSIGNED_BYTE, GL_TRUE, sizeof(Corner),
                          reinterpret_cast<const void*>(offsetof(Corner, color)));  // NOLINT: as GL wants it
  }
  glBindBuffer(GL_ARRAY_BUFFER, buffer_.name());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(packed.size() * sizeof(Corner)), packed.data(),
               GL_DYNAMIC_DRAW);
}

void Triangles::Draw(const DrawContext& context, const RigidTransform& T_fixed_triangles, bool blended) {
  const std::size_t count = blended ? blended_ : opaque_;
  if (count == 0) return;
  shaded_program::Begin(program_, context.view, T_fixed_triangles);
  glBindVertexArray(vertices_.name());
  if (blended) shaded_program::BeginBlending(context.marks_depth);
  glDrawArrays(GL_TRIANGLES, static_cast<GLint>(blended ? opaque_ : 0), static_cast<GLsizei>(count));
  if (blended) shaded_program::EndBlending();
}

}  // namespace hgros::viewer
