#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "viewer/data/shapes/scene_shapes.hpp"

namespace hgros::viewer {

/// A name and its place, in ImGui's coordinates.
struct PlacedName {
  float x = 0;
  float y = 0;
  std::string_view text;
  Rgba color = 0;
};

/// Names that would overlap, listed below each other.
struct NamePile {
  struct Entry {
    std::string text;
    Rgba color = 0;
  };
  float x = 0;
  float y = 0;
  std::vector<Entry> entries;
};

/// Names within about one line of each other become one pile at the place of the first one. A long pile shows some
/// names and the number of the others. Names with another color than `usual` are shown first.
[[nodiscard]] std::vector<NamePile> PileNames(std::span<const PlacedName> names, float line_height, Rgba usual);

}  // namespace hgros::viewer
