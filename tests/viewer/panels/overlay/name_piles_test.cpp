#include "viewer/panels/overlay/name_piles.hpp"

#include <gtest/gtest.h>

#include <string>

#include "viewer/data/cut_text.hpp"

namespace hgros::viewer {
namespace {

constexpr float kLine = 14;

constexpr Rgba kUsual = 1;

std::string TextOf(const NamePile& pile) {
  std::string text;
  for (const NamePile::Entry& entry : pile.entries) text += (text.empty() ? "" : "\n") + entry.text;
  return text;
}

std::vector<Rgba> ColorsOf(const NamePile& pile) {
  std::vector<Rgba> colors;
  for (const NamePile::Entry& entry : pile.entries) colors.push_back(entry.color);
  return colors;
}

TEST(NamePiles, KeepSeparateNamesApart) {
  const std::vector<PlacedName> names = {{10, 10, "map", 1}, {10, 30, "odom", 2}, {40, 10, "base", 3}};
  const std::vector<NamePile> piles = PileNames(names, kLine, kUsual);
  ASSERT_EQ(piles.size(), 3U);
  EXPECT_EQ(TextOf(piles[1]), "odom");
  EXPECT_EQ(piles[1].y, 30);
  EXPECT_EQ(ColorsOf(piles[1]), std::vector<Rgba>({2}));
}

TEST(NamePiles, ListNamesAtTheSamePlaceBelowEachOther) {
  const std::vector<PlacedName> names = {{10, 10, "map", 1}, {90, 10, "lidar", 1}, {11, 12, "odom", 2}};
  const std::vector<NamePile> piles = PileNames(names, kLine, kUsual);
  ASSERT_EQ(piles.size(), 2U);
  EXPECT_EQ(TextOf(piles[0]), "map\nodom");
  EXPECT_EQ(piles[0].x, 10);
}

TEST(NamePiles, KeepTheColorOfEachNameInAnyOrder) {
  const std::vector<PlacedName> last = {{10, 10, "map", 1}, {10, 10, "odom", 2}};
  EXPECT_EQ(ColorsOf(PileNames(last, kLine, kUsual)[0]), std::vector<Rgba>({1, 2}));
  const std::vector<PlacedName> first = {{10, 10, "odom", 2}, {10, 10, "map", 1}};
  EXPECT_EQ(ColorsOf(PileNames(first, kLine, kUsual)[0]), std::vector<Rgba>({2, 1}));
}

TEST(NamePiles, ShowColoredNamesFirst) {
  std::vector<PlacedName> names(8, {10, 10, "wheel", 1});
  names[0].x = 11;
  names[7] = {10, 10, "arm", 2};
  const NamePile cut = PileNames(names, kLine, kUsual)[0];
  EXPECT_EQ(TextOf(cut), "arm\nwheel\nwheel\nwheel\nwheel\nand 3 more");
  EXPECT_EQ(ColorsOf(cut), std::vector<Rgba>({2, 1, 1, 1, 1, 1}));
  EXPECT_EQ(cut.x, 11) << "it stays in its place";
  for (PlacedName& name : names) name.color = 2;
  EXPECT_EQ(ColorsOf(PileNames(names, kLine, kUsual)[0]), std::vector<Rgba>(6, 2))
      << "also of those that are not named";
}

TEST(NamePiles, ShowSomeOfManyNamesAndTheNumberOfTheRest) {
  const std::vector<PlacedName> names(8, {10, 10, "wheel", 1});
  EXPECT_EQ(TextOf(PileNames(names, kLine, kUsual)[0]), "wheel\nwheel\nwheel\nwheel\nwheel\nand 3 more");
  const std::span<const PlacedName> six = std::span(names).first(6);
  EXPECT_EQ(TextOf(PileNames(six, kLine, kUsual)[0]), "wheel\nwheel\nwheel\nwheel\nwheel\nwheel");
  EXPECT_TRUE(PileNames({}, kLine, kUsual).empty());
}

TEST(NamePiles, StayWithinTheLimitOfOneText) {
  const std::string hostile(kMaxShownBytes, 'x');
  const std::vector<PlacedName> names(6, {10, 10, hostile, 1});
  EXPECT_LE(TextOf(PileNames(names, kLine, kUsual)[0]).size(), kMaxShownBytes + 64);
}

}  // namespace
}  // namespace hgros::viewer
