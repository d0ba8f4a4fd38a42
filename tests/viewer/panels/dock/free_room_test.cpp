#include "viewer/panels/dock/free_room.hpp"

#include <algorithm>
#include <random>
#include <vector>

#include "support/seed.hpp"
#include "viewer/panels/panel_fixture.hpp"

namespace hgros::viewer::test {
namespace {

constexpr PanelPlace kWindow{0, 0, 1280, 800};

TEST(FreeRoom, IsTheLargestRectangleBesideThePanels) {
  EXPECT_EQ(LargestFree(kWindow, {}), kWindow);
  const std::vector<PanelPlace> left = {{8, 8, 292, 560}};
  EXPECT_EQ(LargestFree(kWindow, left), (PanelPlace{300, 0, 980, 800}));
  const std::vector<PanelPlace> three = {{8, 8, 292, 560}, {900, 500, 500, 400}, {0, 780, 1280, 20}};
  EXPECT_EQ(LargestFree(kWindow, three), (PanelPlace{300, 0, 980, 500}));
}

TEST(FreeRoom, IsTheWholeWindowIfPanelsCoverAlmostAll) {
  const std::vector<PanelPlace> all = {{-10, -10, 1285, 900}};
  EXPECT_EQ(LargestFree(kWindow, all), kWindow);
}

/// Area of the largest free rectangle with whole numbers as corners.
float NaiveArea(const PanelPlace& all, const std::vector<PanelPlace>& taken) {
  float best = 0;
  for (float x = 0; x < all.width; ++x) {
    for (float y = 0; y < all.height; ++y) {
      for (float width = 1; x + width <= all.width; ++width) {
        for (float height = 1; y + height <= all.height; ++height) {
          const bool is_free = std::ranges::none_of(taken, [&](const PanelPlace& one) {
            return one.x < x + width && one.x + one.width > x && one.y < y + height && one.y + one.height > y;
          });
          if (is_free) best = std::max(best, width * height);
        }
      }
    }
  }
  return best;
}

TEST(FreeRoom, IsAsLargeAsANaiveSearchFinds) {
  constexpr PanelPlace kAll{0, 0, 12, 9};
  std::mt19937 random(hgros::test::Seed());
  const auto number = [&](int least, int most) {
    return static_cast<float>(std::uniform_int_distribution<int>(least, most)(random));
  };
  for (int round = 0; round < 100; ++round) {
    std::vector<PanelPlace> taken(static_cast<std::size_t>(round % 6));
    for (PanelPlace& one : taken) one = {number(-2, 11), number(-2, 8), number(1, 6), number(1, 6)};
    const PanelPlace found = LargestFree(kAll, taken);
    const float area = NaiveArea(kAll, taken);
    EXPECT_EQ(found.width * found.height, area < 0.1F * 12 * 9 ? 12 * 9 : area);
  }
}

using FreeRoomOfPanels = PanelTest;

TEST_F(FreeRoomOfPanels, IsTheSameInsideAndAfterAFrame) {
  const PanelPlace expected{300, 0, 980, 800};
  for (int frame = 0; frame < 3; ++frame) {
    ImGui::NewFrame();
    EXPECT_EQ(FreeRoom(), frame > 0 ? expected : kWindow) << "of the last frame";
    ImGui::SetNextWindowPos({8, 8});
    ImGui::SetNextWindowSize({292, 560});
    ImGui::Begin("panel");
    ImGui::End();
    ImGui::Render();
    EXPECT_EQ(FreeRoom(), expected);
  }
}

}  // namespace
}  // namespace hgros::viewer::test
