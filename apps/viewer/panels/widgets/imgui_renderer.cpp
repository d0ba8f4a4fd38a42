#include "viewer/panels/widgets/imgui_renderer.hpp"

#include <imgui.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace hgros::viewer {
namespace {

constexpr const char* kVertex = R"(
layout(location = 0) in vec2 position;
layout(location = 1) in vec2 uv;
layout(location = 2) in vec4 tint;
uniform vec2 display_size;
out vec2 at;
out vec4 color;
void main() {
  at = uv;
  color = tint;
  gl_Position = vec4(2.0 * position.x / display_size.x - 1.0, 1.0 - 2.0 * position.y / display_size.y, 0, 1);
}
)";

constexpr const char* kFragment = R"(
in vec2 at;
in vec4 color;
uniform sampler2D image;
out vec4 result;
void main() { result = color * texture(image, at); }
)";

}  // namespace

ImguiRenderer::ImguiRenderer() : program_("panels", "", kVertex, kFragment) {}

bool ImguiRenderer::MakeFontTexture() {
  unsigned char* pixels = nullptr;
  int width = 0;
  int height = 0;
  ImFontAtlas& atlas = *ImGui::GetIO().Fonts;
  atlas.GetTexDataAsAlpha8(&pixels, &width, &height);
  GLint most = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
  if (std::max(width, height) > most) return false;
  font_ = GlTexture::New();
  glBindTexture(GL_TEXTURE_2D, font_.name());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_R8, width, height, 0, GL_RED, GL_UNSIGNED_BYTE, pixels);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  const GLint swizzle[] = {GL_ONE, GL_ONE, GL_ONE, GL_RED};
  glTexParameteriv(GL_TEXTURE_2D, GL_TEXTURE_SWIZZLE_RGBA, swizzle);
  atlas.SetTexID(reinterpret_cast<ImTextureID>(static_cast<std::uintptr_t>(font_.name())));  // NOLINT: ImGui's way
  atlas.ClearTexData();
  return true;
}

void ImguiRenderer::Draw() {
  const ImDrawData* const data = ImGui::GetDrawData();
  if (data == nullptr || data->CmdListsCount == 0) return;
  if (!array_) {
    array_ = GlVertexArray::New();
    vertices_ = GlBuffer::New();
    indices_ = GlBuffer::New();
    glBindVertexArray(array_.name());
    glBindBuffer(GL_ARRAY_BUFFER, vertices_.name());
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.name());
    const auto attribute = [](GLuint at, GLint size, GLenum type, GLboolean normalized, std::size_t offset) {
      glEnableVertexAttribArray(at);
      glVertexAttribPointer(at, size, type, normalized, sizeof(ImDrawVert),
                            reinterpret_cast<const void*>(offset));  // NOLINT: as GL wants it
    };
    attribute(0, 2, GL_FLOAT, GL_FALSE, offsetof(ImDrawVert, pos));
    attribute(1, 2, GL_FLOAT, GL_FALSE, offsetof(ImDrawVert, uv));
    attribute(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, offsetof(ImDrawVert, col));
  }
  const ImVec2 size = data->DisplaySize;
  const float to_pixels = data->FramebufferScale.x;
  glViewport(0, 0, static_cast<GLsizei>(size.x * to_pixels), static_cast<GLsizei>(size.y * to_pixels));
  program_.Use();
  program_.Set("display_size", Eigen::Vector2f(size.x, size.y));
  program_.Set("image", 0);
  glActiveTexture(GL_TEXTURE0);
  glBindVertexArray(array_.name());
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  glDisable(GL_DEPTH_TEST);
  glEnable(GL_SCISSOR_TEST);
  for (int n = 0; n < data->CmdListsCount; ++n) {
    const ImDrawList& list = *data->CmdLists[n];
    glBindBuffer(GL_ARRAY_BUFFER, vertices_.name());
    glBufferData(GL_ARRAY_BUFFER, list.VtxBuffer.size_in_bytes(), list.VtxBuffer.Data, GL_STREAM_DRAW);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, list.IdxBuffer.size_in_bytes(), list.IdxBuffer.Data, GL_STREAM_DRAW);
    for (const ImDrawCmd& command : list.CmdBuffer) {
      if (command.UserCallback != nullptr) continue;
      const ImVec4 clip = command.ClipRect;
      if (clip.z <= clip.x || clip.w <= clip.y) continue;
      glScissor(static_cast<GLint>(clip.x * to_pixels), static_cast<GLint>((size.y - clip.w) * to_pixels),
                static_cast<GLsizei>((clip.z - clip.x) * to_pixels),
                static_cast<GLsizei>((clip.w - clip.y) * to_pixels));
      glBindTexture(GL_TEXTURE_2D, static_cast<GLuint>(reinterpret_cast<std::uintptr_t>(command.GetTexID())));
      glDrawElementsBaseVertex(GL_TRIANGLES, static_cast<GLsizei>(command.ElemCount),
                               sizeof(ImDrawIdx) == 2 ? GL_UNSIGNED_SHORT : GL_UNSIGNED_INT,
                               reinterpret_cast<const void*>(command.IdxOffset * sizeof(ImDrawIdx)),  // NOLINT
                               static_cast<GLint>(command.VtxOffset));
    }
  }
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_BLEND);
}

}  // namespace hgros::viewer
