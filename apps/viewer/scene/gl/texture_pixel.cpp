#include "viewer/scene/gl/texture_pixel.hpp"

#include "viewer/scene/gl/gl_object.hpp"

namespace hgros::viewer {

std::array<std::uint8_t, 4> TexturePixel(GLuint texture, std::size_t x, std::size_t y) {
  GLint before = 0;
  glGetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &before);
  const GlFramebuffer framebuffer = GlFramebuffer::New();
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer.name());
  glFramebufferTexture2D(GL_READ_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
  std::array<std::uint8_t, 4> pixel{};
  glReadPixels(static_cast<GLint>(x), static_cast<GLint>(y), 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, pixel.data());
  glBindFramebuffer(GL_READ_FRAMEBUFFER, static_cast<GLuint>(before));
  return pixel;
}

}  // namespace hgros::viewer
