#include "viewer/panels/dock/free_room.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace hgros::viewer {
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

}  // namespace
}  // namespace hgros::viewer
