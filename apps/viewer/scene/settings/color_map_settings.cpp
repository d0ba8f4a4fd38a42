#include "viewer/scene/settings/color_map_settings.hpp"

#include "viewer/data/color_map.hpp"

namespace hgros::viewer {

std::array<Setting, 4> ColorMapSettings(const ColorMapChoice& choice, const std::string& range,
                                        const std::function<bool()>& mapped, const Setting::Need& of_mapped) {
  const auto ranged = [mapped, automatic = choice.auto_range] { return mapped() && !*automatic; };
  const Setting::Need of_ranged{"auto range", {"off"}};
  return {{
      {"map",
       "The color map, from the lowest to the highest value.",
       Setting::Choice{choice.map, {kColorMapNames.begin(), kColorMapNames.end()}},
       mapped,
       {of_mapped}},
      {"auto range", range, Setting::Switch{choice.auto_range}, mapped, {of_mapped}},
      {"lowest",
       "The value of the first color.",
       Setting::Number{choice.lowest, -1e6F, 1e6F, ""},
       ranged,
       {of_mapped, of_ranged}},
      {"highest",
       "The value of the last color.",
       Setting::Number{choice.highest, -1e6F, 1e6F, ""},
       ranged,
       {of_mapped, of_ranged}},
  }};
}

}  // namespace hgros::viewer
