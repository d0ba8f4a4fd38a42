#include "viewer/panels/overlay/label_layer.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "viewer/panels/panel_fixture.hpp"
#include "viewer/panels/widgets/text_lines.hpp"

namespace hgros::viewer::test {
namespace {

class LabelLayer : public PanelTest {
 protected:
  LabelLayer() { ImGui::GetIO().BackendFlags |= ImGuiBackendFlags_RendererHasVtxOffset; }

  /// Number of triangles for `count` labels in the middle of the picture.
  int DrawLabelsOf(const Label& label, std::size_t count) {
    return Frame([&] { DrawLabels(std::vector<Label>(count, label), camera_, {1280, 800}, 1); });
  }
  static Label White(const std::string& text) {
    return {Eigen::Vector3d::Zero(), text, MakeRgba(255, 255, 255), 3, false};
  }

  Camera camera_;
};

TEST_F(LabelLayer, DrawsTheBeginningOfAnyLongText) {
  std::string text;
  for (int i = 0; i < 200; ++i) text += std::string(120, 'x') + '\n';
  EXPECT_GT(DrawLabelsOf(White(text), 1), 0);
  EXPECT_LT(DrawLabelsOf(White(text), 1), 20'000);
}

TEST_F(LabelLayer, DrawsSomeOfAnyNumberOfTexts) {
  const int thousand = DrawLabelsOf(White("kitchen"), 1000);
  EXPECT_EQ(thousand, 1000 * 7 * 2 * 2);
  EXPECT_EQ(DrawLabelsOf(White("kitchen"), 100'000), thousand);
  EXPECT_LT(DrawLabelsOf(White(std::string(4000, 'x')), 1000), 2 * 2 * 100'000);
}

TEST_F(LabelLayer, ListsNamesAtTheSamePlace) {
  const auto triangles = [&](std::size_t count) { return DrawLabelsOf({Eigen::Vector3d::Zero(), "kitchen"}, count); };
  EXPECT_EQ(triangles(3), 3 * triangles(1));
  EXPECT_EQ(triangles(60), triangles(70)) << "the number of lines is limited";
}

TEST_F(LabelLayer, KeepsColorsOfNamesAtTheSamePlace) {
  constexpr Rgba kOrange = MakeRgba(255, 178, 90);
  const std::vector<Label> labels = {{Eigen::Vector3d::Zero(), "map\nodom", MakeRgba(235, 238, 242)},
                                     {Eigen::Vector3d::Zero(), "base", kOrange}};
  ImGui::NewFrame();
  DrawLabels(labels, camera_, {1280, 800}, 1);
  float usual_y = 0;
  float orange_y = 1e6F;
  std::size_t orange = 0;
  for (const ImDrawVert& corner : ImGui::GetBackgroundDrawList()->VtxBuffer) {
    if (corner.col == labels[0].color) usual_y = std::max(usual_y, corner.pos.y);
    if (corner.col != kOrange) continue;
    orange_y = std::min(orange_y, corner.pos.y);
    ++orange;
  }
  ImGui::Render();
  EXPECT_EQ(orange, 4 * 4U) << "four letters have four corners each";
  EXPECT_LE(usual_y, orange_y + 2) << "below both lines of the other";
}

TEST_F(LabelLayer, DrawsTheBeginningOfAnyLongWarning) {
  ImGui::GetIO().DisplaySize = {10'000, 10'000};
  ImGui::NewFrame();
  ImGui::SetNextWindowSize({9'000, 9'000});
  ImGui::Begin("warnings");
  DrawWarning(std::string(100'000, 'x'));
  ImGui::End();
  ImGui::Render();
  EXPECT_GT(ImGui::GetDrawData()->TotalIdxCount / 3, 2 * 4000);
}

}  // namespace
}  // namespace hgros::viewer::test
