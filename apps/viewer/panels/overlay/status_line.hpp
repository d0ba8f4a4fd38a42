#pragma once

#include <cstddef>
#include <string>

namespace hgros::viewer {

struct StatusFigures {
  double frames_per_second = 0;  ///< 0: nothing was drawn recently.
  std::size_t points = 0;
  std::size_t gpu_bytes = 0;
  std::size_t resident_bytes = 0;
  std::string fixed_frame;
  std::string notice;  ///< The last event, as a sentence; may be empty.
  bool paused = false;
  bool picking = false;
  bool unfinished = false;
};

/// The figures as text.
[[nodiscard]] std::string StatusText(const StatusFigures& figures);
/// Draws one line at the lower edge of the window.
void DrawStatusLine(const StatusFigures& figures);

}  // namespace hgros::viewer
