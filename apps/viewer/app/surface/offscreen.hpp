#pragma once

#include <memory>

#include "viewer/app/surface/surface.hpp"

namespace hgros::viewer {

/// Draws into memory with EGL, without a window system: on machines without a screen, and in tests.
class Offscreen : public Surface {
 public:
  /// Errors: throws Error if EGL or OpenGL 3.3 is missing.
  explicit Offscreen(const Viewport& size);
  ~Offscreen() override;

  void Wait(double seconds) override;
  void Wake() override;
  [[nodiscard]] bool TakeDisturbed() override { return false; }
  [[nodiscard]] std::vector<InputEvent> TakeInput() override { return {}; }
  [[nodiscard]] bool hidden() const override { return false; }
  [[nodiscard]] bool closing() const override { return false; }
  [[nodiscard]] Viewport size() const override { return size_; }
  [[nodiscard]] float scale() const override { return 1; }
  void BeginPanels() override;
  [[nodiscard]] GLuint framebuffer() const override;
  void Present() override;

 private:
  struct Egl;

  Viewport size_;
  std::unique_ptr<Egl> egl_;
  int wake_descriptor_ = -1;
  double panels_s_ = 0;
};

}  // namespace hgros::viewer
