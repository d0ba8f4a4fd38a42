#pragma once

#include <string>

#include "viewer/app/surface/surface.hpp"

struct GLFWwindow;

namespace hgros::viewer {

/// A window on the desktop, with its mouse and keyboard. At most one at a time in a process.
class Window : public Surface {
 public:
  /// Errors: throws Error if there is no screen, or no OpenGL 3.3.
  Window(const std::string& title, const Viewport& size);
  ~Window() override;

  void Wait(double seconds) override;
  void Wake() override;
  [[nodiscard]] bool TakeDisturbed() override;
  [[nodiscard]] std::vector<InputEvent> TakeInput() override;
  [[nodiscard]] bool hidden() const override;
  [[nodiscard]] bool closing() const override;
  [[nodiscard]] bool lost() const override;
  [[nodiscard]] Viewport size() const override;
  [[nodiscard]] float scale() const override { return scale_; }
  void BeginPanels() override;
  [[nodiscard]] GLuint framebuffer() const override { return 0; }
  void Present() override;

  /// Call it when ImGui has its context.
  void ConnectPanels();

 private:
  void InstallCallbacks();
  void OnKey(int key, int action);
  /// Whether the pointer is over a panel now.
  [[nodiscard]] bool OverPanel() const;
  /// Pixels per unit of the window's coordinates.
  [[nodiscard]] double PixelsPerUnit() const;

  GLFWwindow* window_ = nullptr;
  float scale_ = 1;
  bool tells_loss_ = false;  ///< The driver reports a reset.
  bool disturbed_ = true;
  bool panels_connected_ = false;
  std::vector<InputEvent> input_;
  double x_ = 0;
  double y_ = 0;
};

}  // namespace hgros::viewer
