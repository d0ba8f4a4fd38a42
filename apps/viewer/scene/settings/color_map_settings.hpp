#pragma once

#include <array>
#include <functional>
#include <string>

#include "viewer/scene/settings/setting.hpp"

namespace hgros::viewer {

/// Where a display stores how its values are colored.
struct ColorMapChoice {
  int* map;  ///< An index into kColorMapNames.
  bool* auto_range;
  float* lowest;
  float* highest;
};

/// The settings "map", "auto range", "lowest" and "highest", in this order. They have an effect while `mapped`, which
/// the need `of_mapped` ensures. `range` says what auto range covers.
[[nodiscard]] std::array<Setting, 4> ColorMapSettings(const ColorMapChoice& choice, const std::string& range,
                                                      const std::function<bool()>& mapped,
                                                      const Setting::Need& of_mapped);

}  // namespace hgros::viewer
