#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "viewer/scene/settings/color_map_settings.hpp"
#include "viewer/scene/settings/setting.hpp"

namespace hgros::viewer {
namespace {

using ::testing::HasSubstr;

TEST(Setting, IsWrittenAndReadAsText) {
  bool on = false;
  float number = 0;
  int choice = 0;
  std::array<float, 3> color = {0, 0, 0};
  std::string text;
  const std::vector<std::pair<Setting, std::string>> cases = {
      {{"names", "", Setting::Switch{&on}}, "on"},
      {{"size", "", Setting::Number{&number, 0, 10, "px"}}, "2.5"},
      {{"keep", "", Setting::Choice{&choice, {"latest", "all"}}}, "all"},
      {{"flat", "", Setting::Color{&color}}, "#ff8040"},
      {{"field", "", Setting::Text{&text}}, "ring"},
  };
  for (const auto& [setting, words] : cases) {
    EXPECT_EQ(SetFromText(setting, words), "");
    EXPECT_EQ(TextOf(setting), words);
  }
}

TEST(Setting, ReportsInvalidTexts) {
  bool on = false;
  float number = 1;
  int choice = 0;
  std::array<float, 3> color = {0, 0, 0};
  EXPECT_THAT(SetFromText({"names", "", Setting::Switch{&on}}, "perhaps"), HasSubstr("on or off"));
  EXPECT_THAT(SetFromText({"size", "", Setting::Number{&number, 0, 10, ""}}, "3px"), HasSubstr("number"));
  EXPECT_THAT(SetFromText({"size", "", Setting::Number{&number, 0, 10, ""}}, "nan"), HasSubstr("number"));
  EXPECT_THAT(SetFromText({"keep", "", Setting::Choice{&choice, {"latest", "count", "all"}}}, "some"),
              HasSubstr("latest, count and all"));
  EXPECT_THAT(SetFromText({"flat", "", Setting::Color{&color}}, "red"), HasSubstr("#ff8000"));
  EXPECT_EQ(number, 1);
}

TEST(Setting, NumbersStayWithinTheirLimits) {
  float number = 1;
  EXPECT_EQ(SetFromText({"size", "", Setting::Number{&number, 0, 10, ""}}, "99"), "");
  EXPECT_EQ(number, 10);
}

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
