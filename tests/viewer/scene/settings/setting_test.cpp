#include "viewer/scene/settings/setting.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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

}  // namespace
}  // namespace hgros::viewer
