#include "viewer/scene/layers/line_pieces.hpp"

#include <vector>

#include "viewer/scene/gl/shaded_program.hpp"
#include "viewer/scene/layers/line_program.hpp"

namespace hgros::viewer {
namespace {

constexpr const char* kLineVertex = R"(
layout(location = 0) in vec3 from;
layout(location = 1) in vec3 to;
layout(location = 2) in vec4 from_color;
layout(location = 3) in vec4 to_color;
layout(location = 4) in vec2 width;
uniform float scale;
out vec4 graded;
void main() {
  gl_Position = OnScreen(from, to, gl_VertexID, mix(scale, 1.0, width.y) * width.x, width.y);
  graded = gl_VertexID == 1 || gl_VertexID == 2 || gl_VertexID == 4 ? to_color : from_color;
  color = graded;
}
)";

constexpr const char* kLineFragment = R"(
in vec4 graded;
out vec4 result;
void main() { result = graded; }
)";

std::array<float, 3> Floats(const Eigen::Vector3d& at) {
  return {static_cast<float>(at.x()), static_cast<float>(at.y()), static_cast<float>(at.z())};
}

bool IsBlended(const LinePiece& piece) { return AlphaOf(piece.from_color) < 255 || AlphaOf(piece.to_color) < 255; }

}  // namespace

LinePieces::LinePieces() : program_("lines", "", line_program::VertexSource(kLineVertex), kLineFragment) {}

void LinePieces::Set(std::span<const LinePiece> pieces) {
  opaque_ = blended_ = 0;
  if (pieces.empty()) return;
  std::vector<Instance> instances;
  instances.reserve(pieces.size());
  for (const bool blended : {false, true}) {
    for (const LinePiece& piece : pieces) {
      if (IsBlended(piece) != blended || IsInvisible(piece)) continue;
      instances.push_back({Floats(piece.from),
                           Floats(piece.to),
                           piece.from_color,
                           piece.to_color,
                           {piece.thickness, piece.pixels ? 0.0F : 1.0F}});
    }
    (blended ? blended_ : opaque_) = instances.size() - opaque_;
  }
  if (!buffer_) {
    buffer_ = GlBuffer::New();
    vertices_ = GlVertexArray::New();
  }
  glBindBuffer(GL_ARRAY_BUFFER, buffer_.name());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(instances.size() * sizeof(Instance)), instances.data(),
               GL_DYNAMIC_DRAW);
}

void LinePieces::Draw(const DrawContext& context, const RigidTransform& T_fixed_lines, bool blended) {
  const std::size_t count = blended ? blended_ : opaque_;
  if (count == 0) return;
  line_program::Begin(program_, context.view, T_fixed_lines, 1);
  program_.Set("scale", context.scale);
  glBindVertexArray(vertices_.name());
  glBindBuffer(GL_ARRAY_BUFFER, buffer_.name());
  const std::size_t first = blended ? opaque_ * sizeof(Instance) : 0;
  const auto attribute = [&](GLuint at, GLint size, std::size_t offset) {
    const bool is_color = size == 4;
    glEnableVertexAttribArray(at);
    glVertexAttribDivisor(at, 1);
    glVertexAttribPointer(at, size, is_color ? GL_UNSIGNED_BYTE : GL_FLOAT, is_color ? GL_TRUE : GL_FALSE,
                          sizeof(Instance), reinterpret_cast<const void*>(first + offset));  // NOLINT: as GL wants it
  };
  attribute(0, 3, offsetof(Instance, from));
  attribute(1, 3, offsetof(Instance, to));
  attribute(2, 4, offsetof(Instance, from_color));
  attribute(3, 4, offsetof(Instance, to_color));
  attribute(4, 2, offsetof(Instance, width));
  if (blended) shaded_program::BeginBlending(context.marks_depth);
  glDrawArraysInstanced(GL_TRIANGLES, 0, 6, static_cast<GLsizei>(count));
  if (blended) shaded_program::EndBlending();
}

}  // namespace hgros::viewer
