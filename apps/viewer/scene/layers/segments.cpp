#include "viewer/scene/layers/segments.hpp"

#include "viewer/scene/layers/line_program.hpp"

namespace hgros::viewer {
namespace {

static_assert(sizeof(Segments::Segment) == 28);

constexpr const char* kSegment = R"(
layout(location = 0) in vec3 from;
layout(location = 1) in vec3 to;
layout(location = 2) in vec4 segment_color;
void main() {
  gl_Position = OnScreen(from, to, gl_VertexID);
  color = segment_color;
}
)";

}  // namespace

Segments::Segments() : program_("segments", "", line_program::VertexSource(kSegment), line_program::FragmentSource()) {}

void Segments::Set(std::span<const Segment> segments) {
  count_ = segments.size();
  if (!buffer_) buffer_ = GlBuffer::New();
  glBindBuffer(GL_ARRAY_BUFFER, buffer_.name());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(segments.size_bytes()), segments.data(), GL_DYNAMIC_DRAW);
}

void Segments::Draw(const ViewMatrices& view, const RigidTransform& T_fixed_lines, float width_pixels) {
  if (count_ == 0) return;
  if (!vertices_) {
    vertices_ = GlVertexArray::New();
    glBindVertexArray(vertices_.name());
    glBindBuffer(GL_ARRAY_BUFFER, buffer_.name());
    const auto attribute = [](GLuint at, GLint size, GLenum type, GLboolean normalized, std::size_t offset) {
      glEnableVertexAttribArray(at);
      glVertexAttribDivisor(at, 1);
      glVertexAttribPointer(at, size, type, normalized, sizeof(Segment),
                            reinterpret_cast<const void*>(offset));  // NOLINT: as GL wants it
    };
    attribute(0, 3, GL_FLOAT, GL_FALSE, offsetof(Segment, from));
    attribute(1, 3, GL_FLOAT, GL_FALSE, offsetof(Segment, to));
    attribute(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, offsetof(Segment, color));
  }
  line_program::Begin(program_, view, T_fixed_lines, width_pixels);
  glBindVertexArray(vertices_.name());
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  glDrawArraysInstanced(GL_TRIANGLES, 0, 6, static_cast<GLsizei>(count_));
  glDisable(GL_BLEND);
}

}  // namespace hgros::viewer
