#include "viewer/panels/display_panel.hpp"
#include "viewer/panels/panel_fixture.hpp"

namespace hgros::viewer::test {
namespace {

class DisplayPanelAdd : public PanelTest {
 protected:
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

TEST_F(DisplayPanelAdd, OpensTheListOfChannelsByAClickOnTheWord) {
  EXPECT_EQ(Words().find("foxglove.PointCloud"), std::string::npos);
  const float unit = ImGui::GetFontSize();
  const float on_the_word = 4.5F * unit;
  bool opened = false;
  for (float y = 5 * unit; y < 12 * unit && !opened; y += 0.4F * unit) {
    opened = Click(on_the_word, y).find("foxglove.PointCloud") != std::string::npos;
  }
  EXPECT_TRUE(opened);
}

TEST_F(DisplayPanelAdd, ShowsTheWholeReasonOfARefusal) {
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
