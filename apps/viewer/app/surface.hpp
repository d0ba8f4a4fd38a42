#pragma once

#include <epoxy/gl.h>

#include <cstdint>
#include <vector>

#include "viewer/view/navigation.hpp"

namespace hgros::viewer {

/// What a person did that belongs to the scene and not to a panel. Pixels count from the upper left corner.
struct InputEvent {
  enum class Kind : std::uint8_t { kPress, kRelease, kPointer, kWheel, kKey } kind = Kind::kPointer;
  PointerButton button = PointerButton::kLeft;
  double x = 0;
  double y = 0;
  double steps = 0;  ///< Of the wheel.
  int key = 0;       ///< As KeyRow.
  bool shift = false;
};

/// Where the pictures go: a window, or memory. Thread: the one that made it, but for Wake.
class Surface {
 public:
  Surface() = default;
  Surface(const Surface&) = delete;
  Surface& operator=(const Surface&) = delete;
  virtual ~Surface() = default;

  /// Sleeps until something happens to the surface, somebody calls Wake, or the time is over (infinite: never).
  virtual void Wait(double seconds) = 0;
  /// Thread-safe.
  virtual void Wake() = 0;
  /// Something happened since the last call: a person did something, or the window has to be drawn for another reason.
  [[nodiscard]] virtual bool TakeDisturbed() = 0;
  [[nodiscard]] virtual std::vector<InputEvent> TakeInput() = 0;
  /// Nobody can see it: nothing need be drawn.
  [[nodiscard]] virtual bool hidden() const = 0;
  [[nodiscard]] virtual bool closing() const = 0;

  /// The graphics card was reset, and all that GL had is gone: the surface has to be made anew.
  [[nodiscard]] virtual bool lost() const { return false; }

  [[nodiscard]] virtual Viewport size() const = 0;
  /// Pixels of the screen to a pixel as people set it; another one on another screen.
  [[nodiscard]] virtual float scale() const = 0;
  /// Tells ImGui sizes, time, and what mouse and keys did.
  virtual void BeginPanels() = 0;
  /// The framebuffer that Present shows.
  [[nodiscard]] virtual GLuint framebuffer() const = 0;
  virtual void Present() = 0;
};

}  // namespace hgros::viewer
