#include "viewer/scene/settings/color_map_settings.hpp"

#include <gtest/gtest.h>

#include <string>

namespace hgros::viewer {
namespace {

TEST(ColorMapSettings, HaveAnEffectOnlyWhileColorsAreMapped) {
  int map = 0;
  bool auto_range = true;
  float lowest = 0;
  float highest = 10;
  bool mapped = false;
  const auto settings = ColorMapSettings({&map, &auto_range, &lowest, &highest}, "All there is.",
                                         [&] { return mapped; }, {"color", {"value", "height"}});
  const auto counting = [&] {
    std::string names;
    for (const Setting& setting : settings) names += setting.shown() ? setting.name + ";" : "";
    return names;
  };
  EXPECT_EQ(counting(), "");
  mapped = true;
  EXPECT_EQ(counting(), "map;auto range;");
  auto_range = false;
  EXPECT_EQ(counting(), "map;auto range;lowest;highest;");
  for (const Setting& setting : settings) EXPECT_EQ(setting.needs.front().name, "color") << setting.name;

  const char* const texts[] = {"sea", "on", "-2", "2.5"};
  for (std::size_t i = 0; i < settings.size(); ++i) EXPECT_EQ(SetFromText(settings[i], texts[i]), "");
  EXPECT_EQ(map, 1);
  EXPECT_TRUE(auto_range);
  EXPECT_EQ(lowest, -2);
  EXPECT_EQ(highest, 2.5F);
}

}  // namespace
}  // namespace hgros::viewer
