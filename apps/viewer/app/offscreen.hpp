#pragma once

#include <memory>

#include "viewer/app/surface.hpp"

namespace hgros::viewer {

/// Draws into memory, by EGL without any window system: on a machine without a screen, in tests.
class Offscreen : public Surface {
 public:
  /// Errors: throws Error if there is no such EGL or OpenGL 3.3.
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
