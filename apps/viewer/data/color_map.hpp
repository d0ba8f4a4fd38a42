#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace hgros::viewer {

/// Colors for values from the lowest to the highest.
enum class ColorMap : std::uint8_t { kRainbow, kSea, kFire, kGray };
inline constexpr std::array<std::string_view, 4> kColorMapNames = {"rainbow", "sea", "fire", "gray"};
inline constexpr std::size_t kColorMapSteps = 256;

/// All maps, one after another: kColorMapSteps colors of 3 bytes each.
[[nodiscard]] std::vector<std::uint8_t> ColorMapTable();

}  // namespace hgros::viewer
