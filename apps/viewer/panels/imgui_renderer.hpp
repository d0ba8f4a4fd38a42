#pragma once

#include "viewer/scene/gl_object.hpp"
#include "viewer/scene/shader_program.hpp"

namespace hgros::viewer {

/// Draws what ImGui has laid out, with the same GL functions as the rest. (ImGui's own backend looks for libGL.so at
/// run time, which only developers' machines have.) Thread: the one whose GL context is current.
class ImguiRenderer {
 public:
  ImguiRenderer();
  /// Before each ImGui::NewFrame.
  void Prepare();
  /// ImGui has another font.
  void ForgetFont() { font_ = {}; }
  /// The frame that ImGui::Render has finished, into the bound framebuffer.
  void Draw();

 private:
  void MakeFontTexture();

  ShaderProgram program_;
  GlTexture font_;
  GlBuffer vertices_;
  GlBuffer indices_;
  GlVertexArray array_;
};

}  // namespace hgros::viewer
