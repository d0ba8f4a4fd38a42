#pragma once

#include "viewer/scene/gl/gl_object.hpp"
#include "viewer/scene/gl/shader_program.hpp"

namespace hgros::viewer {

/// Draws ImGui's output with the same GL functions as the rest. (ImGui's own backend loads libGL.so at run time, which
/// only developers' machines have.) Thread: the one whose GL context is current.
class ImguiRenderer {
 public:
  ImguiRenderer();
  /// Call it before each ImGui::NewFrame. Returns whether the graphics card can hold the characters of ImGui's font.
  [[nodiscard]] bool Prepare() { return font_ || MakeFontTexture(); }
  /// Call it when ImGui has another font.
  void ForgetFont() { font_ = {}; }
  /// Draws the output of ImGui::Render into the bound framebuffer.
  void Draw();

 private:
  bool MakeFontTexture();

  ShaderProgram program_;
  GlTexture font_;
  GlBuffer vertices_;
  GlBuffer indices_;
  GlVertexArray array_;
};

}  // namespace hgros::viewer
