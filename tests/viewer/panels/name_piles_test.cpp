#include "viewer/panels/name_piles.hpp"

#include <gtest/gtest.h>

#include <string>

#include "viewer/data/cut_text.hpp"

namespace hgros::viewer {
namespace {

constexpr float kLine = 14;

TEST(NamePiles, LeaveNamesAloneThatLieApart) {
  const std::vector<PlacedName> names = {{10, 10, "map", 1}, {10, 30, "odom", 2}, {40, 10, "base", 3}};
  const std::vector<NamePile> piles = PileNames(names, kLine);
  ASSERT_EQ(piles.size(), 3U);
  EXPECT_EQ(piles[1].text, "odom");
  EXPECT_EQ(piles[1].y, 30);
  EXPECT_EQ(piles[1].color, 2U);
}

TEST(NamePiles, ListNamesBelowEachOtherThatCoincide) {
  const std::vector<PlacedName> names = {{10, 10, "map", 1}, {90, 10, "lidar", 1}, {11, 12, "odom", 2}};
  const std::vector<NamePile> piles = PileNames(names, kLine);
  ASSERT_EQ(piles.size(), 2U);
  EXPECT_EQ(piles[0].text, "map\nodom");
  EXPECT_EQ(piles[0].x, 10);
}

TEST(NamePiles, NameSomeOfManyAndSayHowManyMoreThereAre) {
  const std::vector<PlacedName> names(8, {10, 10, "wheel", 1});
  EXPECT_EQ(PileNames(names, kLine)[0].text, "wheel\nwheel\nwheel\nwheel\nwheel\nand 3 more");
  EXPECT_EQ(PileNames(std::span(names).first(6), kLine)[0].text, "wheel\nwheel\nwheel\nwheel\nwheel\nwheel");
  EXPECT_TRUE(PileNames({}, kLine).empty());
}

TEST(NamePiles, AreNoLongerThanOneTextMayBe) {
  const std::string hostile(kMaxShownBytes, 'x');
  const std::vector<PlacedName> names(6, {10, 10, hostile, 1});
  EXPECT_LE(PileNames(names, kLine)[0].text.size(), kMaxShownBytes + 64);
}

}  // namespace
}  // namespace hgros::viewer
