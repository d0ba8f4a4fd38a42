#include "viewer/scene/layers/pose_strip.hpp"

#include <algorithm>

#include "viewer/scene/layers/line_program.hpp"

namespace hgros::viewer {
namespace {

static_assert(sizeof(PoseList::Pose) == 28);

constexpr const char* kLine = R"(
layout(location = 0) in vec3 from;
layout(location = 1) in vec3 to;
uniform vec3 line_color;
void main() {
  gl_Position = OnScreen(from, to, gl_VertexID);
  color = vec4(line_color, 1);
}
)";

constexpr const char* kAxes = R"(
layout(location = 0) in vec3 position;
layout(location = 2) in vec4 rotation;
uniform float axis_length;
void main() {
  int axis = gl_VertexID / 6;
  vec3 unit = vec3(axis == 0, axis == 1, axis == 2);
  gl_Position = OnScreen(position, position + axis_length * Turned(rotation, unit), gl_VertexID % 6);
  color = vec4(mix(vec3(0.16), vec3(0.93, 0.86, 1.0), unit), 1);
}
)";

}  // namespace

PoseStrip::PoseStrip()
    : line_("trajectory line", "", line_program::VertexSource(kLine), line_program::FragmentSource()),
      axes_("pose axes", "", line_program::VertexSource(kAxes), line_program::FragmentSource()) {}

void PoseStrip::Set(std::span<const PoseList::Pose> poses, std::size_t first) {
  count_ = poses.size();
  if (!buffer_) buffer_ = GlBuffer::New();
  glBindBuffer(GL_ARRAY_BUFFER, buffer_.name());
  if (count_ > capacity_) {
    capacity_ = std::max<std::size_t>(64, count_ + count_ / 4);
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(capacity_ * sizeof(PoseList::Pose)), nullptr,
                 GL_DYNAMIC_DRAW);
    first = 0;
  }
  const auto changed = poses.subspan(std::min(first, poses.size()));
  if (changed.empty()) return;
  glBufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(first * sizeof(PoseList::Pose)),
                  static_cast<GLsizeiptr>(changed.size_bytes()), changed.data());
}

void PoseStrip::Bind(std::size_t first_pose, bool with_next) {
  if (!vertices_) vertices_ = GlVertexArray::New();
  glBindVertexArray(vertices_.name());
  glBindBuffer(GL_ARRAY_BUFFER, buffer_.name());
  const auto attribute = [](GLuint at, GLint size, std::size_t offset) {
    glEnableVertexAttribArray(at);
    glVertexAttribDivisor(at, 1);
    glVertexAttribPointer(at, size, GL_FLOAT, GL_FALSE, sizeof(PoseList::Pose),
                          reinterpret_cast<const void*>(offset));  // NOLINT: as GL wants it
  };
  const std::size_t base = first_pose * sizeof(PoseList::Pose);
  attribute(0, 3, base);
  attribute(2, 4, base + offsetof(PoseList::Pose, rotation));
  if (with_next) {
    attribute(1, 3, base + sizeof(PoseList::Pose));
  } else {
    glDisableVertexAttribArray(1);
  }
}

void PoseStrip::DrawLine(const ViewMatrices& view, const RigidTransform& T_fixed_poses,
                         const std::array<float, 3>& color, float width_pixels, std::size_t first) {
  const std::size_t from = first > 0 ? first - 1 : 0;
  if (count_ < from + 2) return;
  line_program::Begin(line_, view, T_fixed_poses, width_pixels);
  line_.Set("line_color", Eigen::Vector3f(color[0], color[1], color[2]));
  Bind(from, true);
  glDrawArraysInstanced(GL_TRIANGLES, 0, 6, static_cast<GLsizei>(count_ - from - 1));
}

void PoseStrip::DrawAxes(const ViewMatrices& view, const RigidTransform& T_fixed_poses, float length_meters,
                         float width_pixels, std::size_t first) {
  if (count_ <= first) return;
  line_program::Begin(axes_, view, T_fixed_poses, width_pixels);
  axes_.Set("axis_length", length_meters);
  Bind(first, false);
  glDrawArraysInstanced(GL_TRIANGLES, 0, 18, static_cast<GLsizei>(count_ - first));
}

}  // namespace hgros::viewer
