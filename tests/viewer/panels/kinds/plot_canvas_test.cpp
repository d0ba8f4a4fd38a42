#include "viewer/panels/kinds/plot_canvas.hpp"

#include "viewer/panels/panel_fixture.hpp"

namespace hgros::viewer::test {
namespace {

using PlotCanvas = PanelTest;

TEST_F(PlotCanvas, DrawsADotForEachValueWithoutALine) {
  const auto triangles = [](std::size_t values) {
    PlotLine line{"x", IM_COL32_WHITE, {}};
    for (std::size_t i = 0; i < values; ++i) line.columns.push_back({2 * i, 1, 1, 1, 1, true});
    return Frame([&] {
      ImGui::SetNextWindowSize({800, 400});
      ImGui::Begin("plot");
      DrawPlot({line}, 60, "");
      ImGui::End();
    });
  };
  (void)triangles(1);  // A window is hidden in its first frame.
  const int dot = triangles(2) - triangles(1);
  EXPECT_GT(dot, 0);
  EXPECT_EQ(triangles(100) - triangles(99), dot);
}

}  // namespace
}  // namespace hgros::viewer::test
