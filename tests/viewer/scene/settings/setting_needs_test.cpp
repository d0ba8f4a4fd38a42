#include "viewer/scene/settings/setting_needs.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <utility>

#include "viewer/scene/scene_fixture.hpp"

namespace hgros::viewer::test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

class SettingNeeds : public SceneTest {
 protected:
  /// Gives settings to a display of that type. Returns those without effect.
  std::vector<std::string> Give(const std::string& type, std::vector<std::pair<std::string, std::string>> given) {
    display_ = &Add(type, "channel_" + std::to_string(++made_));
    const SettingTexts before = TextsOf(display_->Settings());
    std::vector<std::string> names;
    for (const auto& [name, text] : given) {
      EXPECT_EQ(SetFromText(Find(name), text), "");
      names.push_back(name);
    }
    return MeetNeeds(*display_, names, before);
  }
  Setting Find(const std::string& name) {
    const std::vector<Setting> all = display_->Settings();
    return *std::ranges::find(all, name, &Setting::name);
  }
  std::string Text(const std::string& name) { return TextOf(Find(name)); }

  Display* display_ = nullptr;
  int made_ = 0;
};

TEST_F(SettingNeeds, AreSetUnlessGivenOtherwise) {
  EXPECT_THAT(Give("Point cloud", {{"lowest", "1"}, {"field", "speed"}, {"count", "10"}}), IsEmpty());
  EXPECT_EQ(Text("auto range"), "off");
  EXPECT_EQ(Text("color"), "value");
  EXPECT_EQ(Text("keep"), "count") << "also if the number has not changed";
  EXPECT_THAT(Give("Voxels", {{"highest", "3"}}), IsEmpty());
  EXPECT_EQ(Text("auto range"), "off");
  EXPECT_THAT(Give("Trajectory", {{"axes length", "3"}}), IsEmpty());
  EXPECT_EQ(Text("style"), "both");
}

TEST_F(SettingNeeds, ThatAreGivenOtherwiseAreKeptAndReported) {
  EXPECT_THAT(Give("Point cloud", {{"lowest", "1"}, {"auto range", "on"}, {"map", "fire"}}), ElementsAre("lowest"));
  EXPECT_EQ(Text("auto range"), "on");
  EXPECT_EQ(WhyWithoutEffect(display_->Settings(), "lowest"), "lowest has no effect while auto range is on.");
  EXPECT_EQ(WhyWithoutEffect(display_->Settings(), "map"), "");
  EXPECT_EQ(SetFromText(Find("auto range"), "off"), "");
  EXPECT_EQ(WhyWithoutEffect(display_->Settings(), "lowest"), "") << "now it has an effect";
}

TEST_F(SettingNeeds, OfTheFirstSettingWinWhenTwoContradict) {
  EXPECT_THAT(Give("Laser scan", {{"seconds", "3"}, {"count", "7"}}), ElementsAre("count"));
  EXPECT_EQ(Text("keep"), "time");
}

TEST_F(SettingNeeds, AreNotReportedForDefaultsInAFile) {
  EXPECT_THAT(Give("Point cloud", {{"auto range", "on"}, {"lowest", "0"}, {"highest", "10"}}), IsEmpty());
}

TEST_F(SettingNeeds, NameExistingSettingsAndValues) {
  for (const DisplayType& type : DisplayTypes()) {
    Display& display = Add(type.name, type.schemas.empty() ? "" : "of_" + std::to_string(++made_));
    const std::vector<Setting> all = display.Settings();
    for (const Setting& setting : all) {
      for (const Setting::Need& need : setting.needs) {
        const auto other = std::ranges::find(all, need.name, &Setting::name);
        ASSERT_NE(other, all.end()) << type.name << ": " << need.name;
        for (const std::string& value : need.values) EXPECT_EQ(SetFromText(*other, value), "");
      }
    }
  }
}

}  // namespace
}  // namespace hgros::viewer::test
