#include "viewer/app/layout/layout_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <array>
#include <filesystem>
#include <limits>
#include <random>
#include <string>

#include "support/error_of.hpp"
#include "support/scratch_folder.hpp"

namespace hgros::viewer {
namespace {

Layout FullLayout() {
  Layout layout;
  layout.fixed_frame = "map";
  layout.follow = "base link";
  layout.follow_pose = true;
  layout.fps_limit = 12.5;
  layout.save_on_exit = true;
  layout.show_found = true;
  layout.camera = LayoutCamera{{500000.125, -0.1, 1e-7}, {0.1, 0.2, 0.3, 0.9}, 17.25, true, {{1, 2, 3}}, true};
  layout.displays = {{{"Ground", "", false, {{"cell", "1"}, {"axes", "on"}}},
                      {"Point cloud", "front/lidar", true, {{"flat", "#ff8000"}, {"field", ""}, {"size", "2.5"}}},
                      {"Image", "camera", true, {}, {}, PanelPlace{900, 10.5F, 320, 240}}}};
  layout.panels = {
      {{"Plot", PanelPlace{10.5F, 20, 400, 300}, {{"seconds", "30"}, {"series", "a x"}, {"series", "b y[0]"}}}, {}},
      {{"Log", std::nullopt, {{"text", "a: \"b\" # c"}}}, {}}};
  return layout;
}

TEST(LayoutFile, ReadsBackWhatWasWritten) {
  EXPECT_EQ(ParseLayout(LayoutText(FullLayout()), "x"), FullLayout());
  EXPECT_EQ(ParseLayout(LayoutText({}), "x"), Layout());
  Layout none;
  none.displays.emplace();
  EXPECT_EQ(ParseLayout(LayoutText(none), "x"), none) << "an empty list of displays must not become a missing list";
}

TEST(LayoutFile, KeepsEveryTextAndNumberExactly) {
  std::mt19937 random(11);
  constexpr std::string_view kLetters = "ab: #\"'\\\n\t-[]{},&*!|>%@`?0~yn.\xC3\xA4";
  for (int i = 0; i < 500; ++i) {
    std::string text;
    for (std::size_t n = random() % 8; n > 0; --n) {
      const std::size_t at = random() % (kLetters.size() - 1);
      text += at == kLetters.size() - 2 ? std::string(kLetters.substr(at)) : std::string(1, kLetters[at]);
    }
    Layout layout;
    layout.fixed_frame = text;
    layout.displays = {{{"k" + text, text, true, {{"s" + text, text}}}}};
    layout.panels = {{{"Log", std::nullopt, {{"text", text}, {"more", text}, {"more", "b"}}}, {}}};
    std::uniform_real_distribution<double> number(-1e6, 1e6);
    layout.camera.emplace().eye = {number(random), number(random) * 1e-9, number(random)};
    ASSERT_EQ(ParseLayout(LayoutText(layout), "x"), layout) << LayoutText(layout);
  }
}

TEST(LayoutFile, OmitsACameraThatCannotBeReadBack) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double number : {kInfinity, -kInfinity, std::numeric_limits<double>::quiet_NaN(), 2e12, -1e300}) {
    std::array<LayoutCamera, 4> cameras;
    cameras[0].eye[1] = number;
    cameras[1].orientation[0] = number;
    cameras[2].distance = number;
    cameras[3].anchor = {0, 0, number};
    for (const LayoutCamera& camera : cameras) {
      Layout layout;
      layout.camera = camera;
      EXPECT_EQ(ParseLayout(LayoutText(layout), "x"), Layout()) << number;
    }
  }
}

TEST(LayoutFile, ReadsAFileWrittenByHand) {
  const Layout layout = ParseLayout(R"(
fixed_frame: odom
displays:
  - kind: Frames
  - kind: Point cloud
    channel: lidar
    settings: {keep: all, size: 3}
panels: [Graph, {kind: Plot, series: odometry pose.position.x}]
)",
                                    "x");
  ASSERT_EQ(layout.displays->size(), 2U);
  EXPECT_TRUE((*layout.displays)[0].visible);
  EXPECT_EQ((*layout.displays)[1].settings[1], (LayoutSetting{"size", "3"}));
  ASSERT_EQ(layout.panels.size(), 2U);
  EXPECT_EQ(layout.panels[0].panel.name, "Graph");
  EXPECT_EQ(layout.panels[1].panel.settings[0].second, "odometry pose.position.x");
}

TEST(LayoutFile, ReportsLineAndFixOfEachError) {
  const std::pair<const char*, std::vector<const char*>> cases[] = {
      {"fps: 30", {"layout.yaml:1:1", "\"fps\"", "fps_limit"}},
      {"fps_limit: fast", {"layout.yaml:1:12", "a number"}},
      {"fps_limit: 0", {"above 0"}},
      {"displays:\n  kind: Ground", {"layout.yaml:2", "a list"}},
      {"displays:\n  - {kind: Image, place: [1, 2, 3, 0]}", {"no size", "in pixels"}},
      {"displays:\n  - channel: lidar", {"layout.yaml:2", "has no \"kind\""}},
      {"displays:\n  - kind: Ground\n    size: 3", {"layout.yaml:3:5", "settings"}},
      {"displays:\n  - kind: Ground\n    settings:\n      cell: [1]", {"layout.yaml:4", "a text or a number"}},
      {"camera: {eye: [1, 2]}", {"3 numbers"}},
      {"camera: {orientation: [0, 0, 0, 0]}", {"quaternion"}},
      {"camera: {distance: -1}", {"above 0"}},
      {"camera: {eye: [1, 2, nan]}", {"a number"}},
      {"camera: {eye: [1, 2, 2e12]}", {"between -1e12 and 1e12"}},
      {"panels:\n  - place: [1, 2, 3, 4]", {"has no \"kind\""}},
      {"panels:\n  - {kind: Log, place: [1, 2, 0, 0]}", {"no size"}},
      {"save_on_exit: maybe", {"true or false"}},
      {"displays: [", {"layout.yaml:1"}},
      {"- a\n- b", {"A layout must be a map"}},
  };
  for (const auto& [text, words] : cases) {
    const std::string fault = hgros::test::ErrorOf([&text = text] { (void)ParseLayout(text, "layout.yaml"); });
    EXPECT_TRUE(fault.starts_with("layout.yaml:")) << fault;
    for (const char* const word : words) EXPECT_NE(fault.find(word), std::string::npos) << text << "\n" << fault;
  }
}

TEST(LayoutFile, IsNoPipeForWhichTheReaderWouldWait) {
  const hgros::test::ScratchFolder folder;
  const std::filesystem::path file = folder / "pipe";
  ASSERT_EQ(mkfifo(file.c_str(), 0600), 0);
  const std::string fault = hgros::test::ErrorOf([&] { (void)LoadLayout(file); });
  EXPECT_NE(fault.find("is a pipe or a device. Name a regular file."), std::string::npos) << fault;
}

TEST(LayoutFile, IsWrittenCompletelyOrNotAtAll) {
  const hgros::test::ScratchFolder folder;
  const auto file = folder / "layout.yaml";
  EXPECT_EQ(SaveLayout(FullLayout(), file), "");
  EXPECT_EQ(LoadLayout(file), FullLayout());
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1) << "no other file is beside it";
  std::filesystem::remove_all(folder.path());
  EXPECT_EQ(SaveLayout(FullLayout(), file),
            "The layout cannot be written to " + file.string() + ": No such file or directory.");
}

}  // namespace
}  // namespace hgros::viewer
