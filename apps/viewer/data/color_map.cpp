#include "viewer/data/color_map.hpp"

#include <algorithm>
#include <cmath>
#include <span>

namespace hgros::viewer {
namespace {

using Rgb = std::array<double, 3>;

// Even steps from the lowest value to the highest. The low end is bright enough on a dark background.
constexpr std::array<Rgb, 6> kRainbow = {{{0.29, 0.33, 0.86},
                                          {0.13, 0.68, 0.93},
                                          {0.22, 0.84, 0.52},
                                          {0.78, 0.86, 0.25},
                                          {0.98, 0.62, 0.20},
                                          {0.90, 0.24, 0.20}}};
constexpr std::array<Rgb, 4> kSea = {{{0.22, 0.26, 0.55}, {0.13, 0.55, 0.63}, {0.35, 0.79, 0.51}, {0.96, 0.93, 0.40}}};
constexpr std::array<Rgb, 4> kFire = {{{0.35, 0.12, 0.45}, {0.78, 0.20, 0.37}, {0.97, 0.52, 0.24}, {1.00, 0.93, 0.62}}};
constexpr std::array<Rgb, 2> kGray = {{{0.22, 0.22, 0.22}, {1, 1, 1}}};

void AddMap(std::span<const Rgb> anchors, std::vector<std::uint8_t>& table) {
  for (std::size_t i = 0; i < kColorMapSteps; ++i) {
    const double at = static_cast<double>(i) / (kColorMapSteps - 1) * static_cast<double>(anchors.size() - 1);
    const auto left = std::min(static_cast<std::size_t>(at), anchors.size() - 2);
    const double share = at - static_cast<double>(left);
    for (std::size_t c = 0; c < 3; ++c) {
      const double value = (1 - share) * anchors[left][c] + share * anchors[left + 1][c];
      table.push_back(static_cast<std::uint8_t>(std::lround(255 * value)));
    }
  }
}

}  // namespace

std::vector<std::uint8_t> ColorMapTable() {
  std::vector<std::uint8_t> table;
  table.reserve(kColorMapNames.size() * kColorMapSteps * 3);
  AddMap(kRainbow, table);
  AddMap(kSea, table);
  AddMap(kFire, table);
  AddMap(kGray, table);
  return table;
}

}  // namespace hgros::viewer
