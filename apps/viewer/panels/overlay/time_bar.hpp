#pragma once

#include <cstdint>
#include <string>

namespace hgros::viewer {

/// The contents of the time bar while the picture is paused.
struct TimeBarFigures {
  double back_s = 0;           ///< How far the picture looks back from the newest data.
  double kept_s = 0;           ///< How far it can look back, ...
  bool frames_end_it = false;  ///< ... and whether the limit is how long transforms are kept.
  std::uint64_t dropped = 0;   ///< Messages that were dropped during the pause.
};

struct TimeBarWish {
  bool go_on = false;
  bool step = false;
  bool moved = false;  ///< The slider was moved to `back_s`.
  double back_s = 0;
};

/// How far the slider can go back, as text, and why not farther.
[[nodiscard]] std::string SpanText(const TimeBarFigures& figures);
/// Draws the slider and the buttons above the status line.
[[nodiscard]] TimeBarWish DrawTimeBar(const TimeBarFigures& figures);

}  // namespace hgros::viewer
