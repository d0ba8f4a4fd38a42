#pragma once

#include <cstdint>
#include <string>

namespace hgros::viewer {

/// What there is to say while the view stands still.
struct TimeBarFigures {
  double back_s = 0;           ///< How far before the newest the view is.
  double kept_s = 0;           ///< How far that can be, ...
  bool frames_end_it = false;  ///< ... because the frames are not remembered longer.
  std::uint64_t dropped = 0;   ///< Messages that have been lost since it stands still.
};

struct TimeBarWish {
  bool go_on = false;
  bool step = false;
  bool moved = false;  ///< `back_s` is to be shown.
  double back_s = 0;
};

/// How far the slider goes back, in words, and what ends it there.
[[nodiscard]] std::string SpanText(const TimeBarFigures& figures);
/// Above the status line: how far to look back, and the ways on.
[[nodiscard]] TimeBarWish DrawTimeBar(const TimeBarFigures& figures);

}  // namespace hgros::viewer
