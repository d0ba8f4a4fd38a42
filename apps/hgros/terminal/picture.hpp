#pragma once

#include <string>
#include <vector>

#include "terminal/console.hpp"

namespace hgros::cli {

/// A part of a line of the screen.
struct Span {
  std::string text;  ///< Visible.
  Style style = Style::kPlain;
  bool reversed = false;  ///< Foreground and background take each other's place.
};

/// What a full screen shows, from the top.
struct Picture {
  std::vector<std::vector<Span>> lines;
};

}  // namespace hgros::cli
