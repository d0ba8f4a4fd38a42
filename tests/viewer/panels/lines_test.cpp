#include <imgui_internal.h>

#include <filesystem>

#include "viewer/panels/overlay/status_line.hpp"
#include "viewer/panels/overlay/time_bar.hpp"
#include "viewer/panels/panel_fixture.hpp"
#include "viewer/panels/view_panel.hpp"
#include "viewer/panels/widgets/look.hpp"

namespace hgros::viewer::test {
namespace {

using PanelLines = PanelTest;

TEST_F(PanelLines, StatusIsIdleWhileNothingIsDrawn) {
  StatusFigures figures;
  figures.frames_per_second = 12;
  EXPECT_NE(StatusText(figures).find("12 frames/s"), std::string::npos);
  figures.frames_per_second = 0;
  EXPECT_NE(StatusText(figures).find("idle"), std::string::npos);
  EXPECT_EQ(StatusText(figures).find("frames/s"), std::string::npos);
}

/// Whether a text has characters that are not loaded.
bool NeedsMore(const char* text, Glyphs glyphs) {
  SetLook(1, glyphs);
  unsigned char* pixels = nullptr;
  int width = 0;
  int height = 0;
  ImGui::GetIO().Fonts->GetTexDataAsAlpha8(&pixels, &width, &height);
  ImGui::NewFrame();
  ImGui::GetForegroundDrawList()->AddText({20, 20}, IM_COL32_WHITE, text);
  ImGui::Render();
  return NeedsMoreGlyphs();
}

TEST_F(PanelLines, CharactersThatAreMissingAreLoaded) {
  if (!std::filesystem::exists("/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf")) GTEST_SKIP() << "no font";
  EXPECT_FALSE(NeedsMore("\xC3\xA4 ?", Glyphs::kLatin));
  EXPECT_TRUE(NeedsMore("\xCE\xA9", Glyphs::kLatin)) << "a Greek letter";
  EXPECT_FALSE(NeedsMore("\xCE\xA9 \xD0\x96 \xE2\x89\x88 \xE2\x86\x92", Glyphs::kFont));
  EXPECT_TRUE(NeedsMore("\xEE\x80\x80", Glyphs::kFont)) << "no font has it";
}

TEST_F(PanelLines, EastAsianCharactersAreLoaded) {
  if (!std::filesystem::exists("/usr/share/fonts/opentype/noto/NotoSansCJK-Regular.ttc")) GTEST_SKIP() << "no font";
  const char* const chinese_japanese_korean = "\xE4\xB8\xAD \xE3\x81\x82 \xED\x95\x9C";
  EXPECT_TRUE(NeedsMore(chinese_japanese_korean, Glyphs::kFont));
  EXPECT_FALSE(NeedsMore(chinese_japanese_korean, Glyphs::kAll));
}

TEST_F(PanelLines, TimeBarShowsItsSpanAndLimit) {
  EXPECT_EQ(SpanText({0, 9.84, false, 0}), "spans 9.8 s");
  EXPECT_EQ(SpanText({0, 9.84, true, 0}), "spans 9.8 s (frames)");
}

TEST_F(PanelLines, ViewPanelStaysAtItsEdgeWhenTheWindowIsResized) {
  ViewPanel view;
  Camera camera;
  const TransformTree tree;
  const FixedFrame frame(tree);
  LayoutTarget file;
  const auto room_at_right = [&](float width) {
    ImGui::GetIO().DisplaySize = {width, 800};
    for (int i = 0; i < 3; ++i) Frame([&] { (void)view.Draw(camera, frame, file); });
    const ImGuiWindow& window = *ImGui::FindWindowByName("View");
    return width - window.Pos.x - window.Size.x;
  };
  const float room = room_at_right(1280);
  EXPECT_GT(room, 0);
  EXPECT_LT(room, 30);
  EXPECT_EQ(room_at_right(700), room);
  EXPECT_EQ(room_at_right(1900), room);
}

}  // namespace
}  // namespace hgros::viewer::test
