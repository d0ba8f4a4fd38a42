#pragma once

#include <cstdint>
#include <vector>

#include "viewer/scene/gl/gl_object.hpp"
#include "viewer/view/camera.hpp"

namespace hgros::viewer {

/// A framebuffer with color and depth: 8 bits per channel, 24 bits of depth.
class Picture {
 public:
  /// Sets the size. Returns whether it has changed; then the contents are lost.
  bool Resize(const Viewport& size);
  /// Makes it the target of all drawing.
  void Bind() const;
  void Clear(const float (&rgb)[3]) const;
  /// Copies color and depth into another picture of the same size.
  void CopyTo(const Picture& other) const;
  /// Copies the color into a framebuffer of the same size.
  void ShowOn(GLuint framebuffer) const;
  /// Copies the color from a framebuffer of the same size.
  void TakeFrom(GLuint framebuffer) const;
  /// The nearest depth within a radius around a pixel, counted from the upper left corner. 1 if there is nothing.
  [[nodiscard]] float NearestDepth(int& x, int& y, int radius) const;
  /// Rows from the top, 3 bytes per pixel.
  [[nodiscard]] std::vector<std::uint8_t> Pixels() const;
  [[nodiscard]] const Viewport& size() const noexcept { return size_; }

 private:
  Viewport size_{0, 0};
  GlFramebuffer framebuffer_;
  GlRenderbuffer color_;
  GlRenderbuffer depth_;
};

}  // namespace hgros::viewer
