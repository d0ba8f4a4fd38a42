#include "viewer/panels/dock/panel_tiles.hpp"

#include <gtest/gtest.h>

namespace hgros::viewer {
namespace {

constexpr PanelPlace kRoom{300, 30, 960, 700};
constexpr float kGap = 6;

bool Overlap(const PanelPlace& a, const PanelPlace& b) {
  return a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
}

void ExpectInTheRoomAndApart(const std::vector<PanelPlace>& places) {
  for (std::size_t i = 0; i < places.size(); ++i) {
    EXPECT_GE(places[i].x, kRoom.x);
    EXPECT_GE(places[i].y, kRoom.y);
    EXPECT_LE(places[i].x + places[i].width, kRoom.x + kRoom.width + 0.01F);
    EXPECT_LE(places[i].y + places[i].height, kRoom.y + kRoom.height + 0.01F);
    for (std::size_t j = 0; j < i; ++j) EXPECT_FALSE(Overlap(places[i], places[j])) << i << " and " << j;
  }
}

TEST(PanelTiles, AreStackedFromTheLowerEdgeWhileAllFit) {
  const std::vector<PanelPlace> places = TilePanels(std::vector<PanelSize>{{500, 200}, {2000, 300}}, kRoom, kGap);
  EXPECT_EQ(places[0], (PanelPlace{300, 530, 500, 200}));
  EXPECT_EQ(places[1], (PanelPlace{300, 224, 960, 300}));
}

TEST(PanelTiles, FillTheSpaceWithoutOverlapWhenThereAreMany) {
  for (std::size_t count = 2; count <= 9; ++count) {
    std::vector<PanelSize> wanted(count, {600, 400});
    wanted[1].width = 900;
    const std::vector<PanelPlace> places = TilePanels(wanted, kRoom, kGap);
    ASSERT_EQ(places.size(), count);
    ExpectInTheRoomAndApart(places);
    float area = 0;
    for (const PanelPlace& place : places) area += place.width * place.height;
    EXPECT_GT(area, 0.9F * kRoom.width * kRoom.height) << count;
    EXPECT_EQ(places[1].width, kRoom.width) << "the widest panel has its own row";
  }
}

TEST(ImageTiles, AreApartAndInTheRightPartOfTheRoom) {
  constexpr PanelSize kFrame{20, 50};
  const PanelSize sizes[] = {{640, 480}, {1280, 720}, {480, 640}, {5000, 40}, {3, 4000}};
  for (std::size_t count = 1; count <= 12; ++count) {
    std::vector<PanelSize> images;
    for (std::size_t i = 0; i < count; ++i) images.push_back(sizes[i % std::size(sizes)]);
    const std::vector<PanelPlace> places = TileImages(images, kFrame, 350, 480, kRoom, kGap);
    ASSERT_EQ(places.size(), count);
    ExpectInTheRoomAndApart(places);
    for (const PanelPlace& place : places) {
      EXPECT_GE(place.x, kRoom.x + kRoom.width - 480.01F);
      EXPECT_LE(place.width, 370);
      EXPECT_GE(place.height, kFrame.height);
    }
  }
}

TEST(ImageTiles, GiveTheirShapeToTheWindows) {
  const std::vector<PanelPlace> places =
      TileImages(std::vector<PanelSize>{{640, 480}, {640, 480}}, {20, 50}, 320, 480, kRoom, kGap);
  EXPECT_EQ(places[0], (PanelPlace{920, 440, 340, 290})) << "the lower right corner";
  EXPECT_EQ(places[1], (PanelPlace{920, 144, 340, 290})) << "above it";
}

TEST(ImageTiles, UseTheRoomWhenThereAreMany) {
  const std::vector<PanelSize> images(9, {640, 480});
  float area = 0;
  for (const PanelPlace& place : TileImages(images, {20, 50}, 350, 480, kRoom, kGap))
    area += place.width * place.height;
  EXPECT_GT(area, 0.6F * 480 * kRoom.height);
}

TEST(PanelTiles, AreEmptyForNoPanelAndOneForOnePanel) {
  EXPECT_TRUE(TilePanels({}, kRoom, kGap).empty());
  EXPECT_EQ(TilePanels(std::vector<PanelSize>{{9000, 9000}}, kRoom, kGap)[0], kRoom);
}

}  // namespace
}  // namespace hgros::viewer
