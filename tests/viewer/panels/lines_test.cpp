#include <imgui_internal.h>

#include "viewer/panels/overlay/status_line.hpp"
#include "viewer/panels/overlay/time_bar.hpp"
#include "viewer/panels/panel_fixture.hpp"
#include "viewer/panels/view_panel.hpp"

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
    for (int i = 0; i < 3; ++i) {
      ImGui::NewFrame();
      (void)view.Draw(camera, frame, file);
      ImGui::Render();
    }
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
