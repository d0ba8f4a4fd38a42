#include "viewer/scene/gl/picture.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>

#include "hgros/base/error.hpp"

namespace hgros::viewer {

bool Picture::Resize(const Viewport& size) {
  if (size == size_) return false;
  if (!framebuffer_) {
    framebuffer_ = GlFramebuffer::New();
    color_ = GlRenderbuffer::New();
    depth_ = GlRenderbuffer::New();
  }
  size_ = size;
  glBindRenderbuffer(GL_RENDERBUFFER, color_.name());
  glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, size.width, size.height);
  glBindRenderbuffer(GL_RENDERBUFFER, depth_.name());
  glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, size.width, size.height);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, color_.name());
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth_.name());
  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
    throw Error("The driver cannot draw into a picture of " + std::to_string(size.width) + " x " +
                std::to_string(size.height) + " pixels.");
  }
  return true;
}

void Picture::Bind() const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
  glViewport(0, 0, size_.width, size_.height);
}

void Picture::Clear(const float (&rgb)[3]) const {
  Bind();
  glDepthMask(GL_TRUE);
  glClearColor(rgb[0], rgb[1], rgb[2], 1);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

void Picture::CopyTo(const Picture& other) const {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_.name());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, other.framebuffer_.name());
  glBlitFramebuffer(0, 0, size_.width, size_.height, 0, 0, size_.width, size_.height,
                    GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT, GL_NEAREST);
}

void Picture::ShowOn(GLuint framebuffer) const {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_.name());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
  glBlitFramebuffer(0, 0, size_.width, size_.height, 0, 0, size_.width, size_.height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
}

void Picture::TakeFrom(GLuint framebuffer) const {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer_.name());
  glBlitFramebuffer(0, 0, size_.width, size_.height, 0, 0, size_.width, size_.height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

float Picture::NearestDepth(int& x, int& y, int radius) const {
  const int left = std::clamp(x - radius, 0, size_.width - 1);
  const int right = std::clamp(x + radius, 0, size_.width - 1);
  const int top = std::clamp(y - radius, 0, size_.height - 1);
  const int bottom = std::clamp(y + radius, 0, size_.height - 1);
  const int columns = right - left + 1;
  const int rows = bottom - top + 1;
  std::vector<float> depths(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_.name());
  glReadPixels(left, size_.height - 1 - bottom, columns, rows, GL_DEPTH_COMPONENT, GL_FLOAT, depths.data());
  const float nearest = std::ranges::min(depths);
  if (nearest >= 1) return nearest;
  // A point covers several pixels. Among those with that depth, the nearest to the click is used.
  int best = std::numeric_limits<int>::max();
  const int at_x = x;
  const int at_y = y;
  for (std::size_t i = 0; i < depths.size(); ++i) {
    if (depths[i] > nearest) continue;
    const int column = left + static_cast<int>(i) % columns;
    const int row = bottom - static_cast<int>(i) / columns;
    const int distance = (column - at_x) * (column - at_x) + (row - at_y) * (row - at_y);
    if (distance >= best) continue;
    best = distance;
    x = column;
    y = row;
  }
  return nearest;
}

std::vector<std::uint8_t> Picture::Pixels() const {
  const std::size_t row_bytes = static_cast<std::size_t>(size_.width) * 3;
  std::vector<std::uint8_t> pixels(row_bytes * static_cast<std::size_t>(size_.height));
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_.name());
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, size_.width, size_.height, GL_RGB, GL_UNSIGNED_BYTE, pixels.data());
  for (int top = 0, bottom = size_.height - 1; top < bottom; ++top, --bottom) {  // GL has the bottom row first.
    const auto upper = pixels.begin() + static_cast<std::ptrdiff_t>(row_bytes) * top;
    std::swap_ranges(upper, upper + static_cast<std::ptrdiff_t>(row_bytes),
                     pixels.begin() + static_cast<std::ptrdiff_t>(row_bytes) * bottom);
  }
  return pixels;
}

}  // namespace hgros::viewer
