#pragma once

#include <cstdint>
#include <vector>

#include "viewer/scene/gl_object.hpp"
#include "viewer/view/camera.hpp"

namespace hgros::viewer {

/// Colour and depth that can be drawn into and kept: 8 bits a channel, 24 bits of depth.
class Picture {
 public:
  /// Gives it another size; what it showed is lost then. Whether it had another one.
  bool Resize(const Viewport& size);
  /// What is drawn from here on goes into it.
  void Bind() const;
  void Clear(const float (&rgb)[3]) const;
  /// Colour and depth into another picture of the same size.
  void CopyTo(const Picture& other) const;
  /// The colour into the framebuffer with that name, which has the same size.
  void ShowOn(GLuint framebuffer) const;
  /// The colour of the framebuffer with that name, which has the same size.
  void TakeFrom(GLuint framebuffer) const;
  /// The nearest depth within some pixels around a place counted from the upper left; 1 where there is nothing.
  [[nodiscard]] float NearestDepth(int& x, int& y, int radius) const;
  /// Rows from the top, 3 bytes a pixel.
  [[nodiscard]] std::vector<std::uint8_t> Pixels() const;
  [[nodiscard]] const Viewport& size() const noexcept { return size_; }

 private:
  Viewport size_{0, 0};
  GlFramebuffer framebuffer_;
  GlRenderbuffer color_;
  GlRenderbuffer depth_;
};

}  // namespace hgros::viewer
