#pragma once

#include <epoxy/gl.h>

#include <cstdint>
#include <vector>

#include "viewer/view/navigation.hpp"

namespace hgros::viewer {

/// Mouse or keyboard input for the scene, not for a panel. Pixels count from the upper left corner.
struct InputEvent {
  enum class Kind : std::uint8_t { kPress, kRelease, kPointer, kWheel, kKey } kind = Kind::kPointer;
  PointerButton button = PointerButton::kLeft;
  double x = 0;
  double y = 0;
  double steps = 0;  ///< Steps of the wheel.
  int key = 0;       ///< The key as in KeyRow.
  bool shift = false;
};

/// Where the pictures go: a window, or memory. Thread: the one that made it, except for Wake.
class Surface {
 public:
  Surface() = default;
  Surface(const Surface&) = delete;
  Surface& operator=(const Surface&) = delete;
  virtual ~Surface() = default;

  /// Sleeps until there is input, Wake is called, or the time is over (infinity: no limit).
  virtual void Wait(double seconds) = 0;
  /// Thread-safe.
  virtual void Wake() = 0;
  /// Returns whether there was input since the last call, or the window must be drawn for another reason.
  [[nodiscard]] virtual bool TakeDisturbed() = 0;
  [[nodiscard]] virtual std::vector<InputEvent> TakeInput() = 0;
  /// Nobody can see it, so nothing has to be drawn.
  [[nodiscard]] virtual bool hidden() const = 0;
  [[nodiscard]] virtual bool closing() const = 0;

  /// The graphics card was reset and all GL objects are lost: a new surface is needed.
  [[nodiscard]] virtual bool lost() const { return false; }

  [[nodiscard]] virtual Viewport size() const = 0;
  /// Screen pixels per pixel of a setting. It changes when the window moves to another screen.
  [[nodiscard]] virtual float scale() const = 0;
  /// Passes sizes, time and input to ImGui.
  virtual void BeginPanels() = 0;
  /// The framebuffer that Present shows.
  [[nodiscard]] virtual GLuint framebuffer() const = 0;
  virtual void Present() = 0;
};

}  // namespace hgros::viewer
