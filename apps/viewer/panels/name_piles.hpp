#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "viewer/data/scene_shapes.hpp"

namespace hgros::viewer {

/// A name at its place, in ImGui's coordinates.
struct PlacedName {
  float x = 0;
  float y = 0;
  std::string_view text;
  Rgba color = 0;
};

/// Names that would be printed over each other, listed below each other.
struct NamePile {
  struct Entry {
    std::string text;
    Rgba color = 0;
  };
  float x = 0;
  float y = 0;
  std::vector<Entry> entries;
};

/// Those that lie within about a line of each other become one pile where the first of them lies. Of many some are
/// named, first those of another colour than `usual`, and how many more there are.
[[nodiscard]] std::vector<NamePile> PileNames(std::span<const PlacedName> names, float line_height, Rgba usual);

}  // namespace hgros::viewer
