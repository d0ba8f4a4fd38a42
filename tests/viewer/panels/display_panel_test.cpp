#include "viewer/panels/display_panel.hpp"

#include <imgui_internal.h>

#include "viewer/panels/panel_fixture.hpp"
#include "viewer/panels/widgets/look.hpp"

namespace hgros::viewer::test {
namespace {

/// A display without messages or GL.
class Silent : public Display {
 public:
  [[nodiscard]] Change Update(const UpdateContext& /*context*/) override { return Change::kNothing; }
  [[nodiscard]] std::vector<std::string> Status() const override { return status; }

  std::vector<std::string> status;
};

const DisplayType kSilent = {"Silent", {"Silence"}, [](const DisplayInputs& /*inputs*/) -> std::unique_ptr<Display> {
                               return std::make_unique<Silent>();
                             }};

class DisplayPanelTest : public PanelTest {
 protected:
  void DrawPanel(const std::vector<ChannelRow>& channels) {
    for (int i = 0; i < 2; ++i) Frame([&] { (void)panel_.Draw(scene_, frame_, channels, dock_); });
  }
  void AddSilent() {
    scene_.Add(kSilent, {session_, "scan", [] {}});
  }
  /// Height of its contents, with the display unfolded and a status of `lines` lines.
  float HeightWith(std::size_t lines) {
    auto& display = static_cast<Silent&>(*scene_.entries().front().display);
    display.status.assign(lines, "one of the frames");
    DrawPanel({});
    ImGuiWindow& window = *ImGui::FindWindowByName("Displays");
    const auto* const entry = static_cast<const Display*>(&display);
    window.StateStorage.SetInt(ImHashStr("##entry", 0, window.GetID(entry)), 1);
    DrawPanel({});
    return window.ContentSize.y;
  }
  /// How much of the panel has the color of errors.
  int Orange(const std::vector<ChannelRow>& channels) {
    DrawPanel(channels);
    const float* const rgba = WarningColor::kRgba;
    const ImU32 color = ImGui::ColorConvertFloat4ToU32({rgba[0], rgba[1], rgba[2], rgba[3]});
    int count = 0;
    const ImDrawData& drawn = *ImGui::GetDrawData();
    for (int i = 0; i < drawn.CmdListsCount; ++i) {
      for (const ImDrawVert& corner : drawn.CmdLists[i]->VtxBuffer) count += corner.col == color ? 1 : 0;
    }
    return count;
  }
  /// All texts of the panel, line by line.
  std::string Words() {
    ImGui::NewFrame();
    ImGui::LogToClipboard(0);  // Does not open anything itself.
    (void)panel_.Draw(scene_, frame_, {{"cloud", "foxglove.PointCloud", {}}}, dock_);
    ImGui::LogFinish();
    ImGui::Render();
    return ImGui::GetClipboardText();
  }
  std::string Click(float x, float y) {
    ImGuiIO& io = ImGui::GetIO();
    io.MousePos = {x, y};
    (void)Words();
    io.MouseDown[0] = true;
    (void)Words();
    io.MouseDown[0] = false;
    (void)Words();
    return Words();
  }

  TransformTree tree_;
  FixedFrame frame_{tree_};
  Scene scene_;
  DisplayPanel panel_;
};

TEST_F(DisplayPanelTest, ShowsTypeConflictsInOrange) {
  AddSilent();
  EXPECT_EQ(Orange({}), 0);
  EXPECT_EQ(Orange({{"scan", "Silence", ""}, {"other", "Silence", "They differ."}}), 0)
      << "the conflict is on another channel";
  EXPECT_GT(Orange({{"scan", "Silence", "They differ."}}), 0);
}

TEST_F(DisplayPanelTest, ScrollsALongStatusSoThatSettingsStayVisible) {
  AddSilent();
  EXPECT_GT(HeightWith(3), HeightWith(1)) << "it is unfolded";
  EXPECT_LT(HeightWith(50), HeightWith(10) + 1);
  EXPECT_LT(HeightWith(50), HeightWith(7) + ImGui::GetFontSize());
}

TEST_F(DisplayPanelTest, OpensTheListOfChannelsByAClickOnTheWord) {
  EXPECT_EQ(Words().find("foxglove.PointCloud"), std::string::npos);
  const float unit = ImGui::GetFontSize();
  const float on_the_word = 4.5F * unit;
  bool opened = false;
  for (float y = 5 * unit; y < 12 * unit && !opened; y += 0.4F * unit) {
    opened = Click(on_the_word, y).find("foxglove.PointCloud") != std::string::npos;
  }
  EXPECT_TRUE(opened);
}

TEST_F(DisplayPanelTest, ShowsTheWholeReasonOfARefusal) {
  const std::string why = "\"cloud\" carries foxglove.PointCloud; a Grid shows foxglove.Grid.";
  panel_.Refuse(why);
  std::string words = Words();
  for (char& c : words) c = c == '\n' ? ' ' : c;
  while (words.find("  ") != std::string::npos) words.erase(words.find("  "), 1);
  EXPECT_NE(words.find(why), std::string::npos) << words;
  panel_.Refuse("");
  EXPECT_EQ(Words().find("carries"), std::string::npos);
}

}  // namespace
}  // namespace hgros::viewer::test
