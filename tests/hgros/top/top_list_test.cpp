#include "top/top_list.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace hgros::cli {
namespace {

using testing::ElementsAre;

TopRow ChannelRow(const std::string& name, double rate_hz, const std::string& type = "T") {
  TopRow row;
  row.kind = TopKind::kChannels;
  row.id = name;
  row.channel = name;
  row.cells.resize(TopColumns(TopKind::kChannels).size());
  row.cells[0] = name;
  if (rate_hz >= 0) row.cells[1] = Cell(rate_hz, std::to_string(rate_hz));
  row.cells[7] = type;
  return row;
}

std::vector<std::string> Names(const TopList& list) {
  std::vector<std::string> names;
  for (const TopRow* row : list.shown()) names.push_back(row->channel);
  return names;
}

TEST(TopList, BeginsWithTheLargestNumberAndEndsWithWhatIsUnknown) {
  TopList list(TopKind::kChannels);
  list.Show({ChannelRow("a", 1), ChannelRow("b", -1), ChannelRow("c", 30), ChannelRow("d", 4)});
  EXPECT_THAT(Names(list), ElementsAre("c", "d", "a", "b"));
  list.Reverse();
  EXPECT_THAT(Names(list), ElementsAre("a", "d", "c", "b"));
  EXPECT_TRUE(list.SortBy("channel"));
  EXPECT_THAT(Names(list), ElementsAre("a", "b", "c", "d"));
  EXPECT_FALSE(list.SortBy("cpu_percent"));
}

TEST(TopList, SortsByEachColumnThatIsShownInTurn) {
  TopList list(TopKind::kSessions);
  const std::size_t first = list.sorted_by();
  std::size_t steps = 0;
  do {
    list.SortByNeighbor(1);
    EXPECT_NE(list.columns()[list.sorted_by()].heading, "");
    ++steps;
  } while (list.sorted_by() != first && steps < 100);
  EXPECT_GT(steps, 5U);
  EXPECT_LT(steps, list.columns().size());
}

TEST(TopList, ShowsRowsThatContainATextWhateverItsCase) {
  TopList list(TopKind::kChannels);
  list.Show({ChannelRow("Scan", 1), ChannelRow("image", 2, "foxglove.SCAN"), ChannelRow("odom", 3)});
  list.Filter("sCAn");
  EXPECT_THAT(Names(list), ElementsAre("image", "Scan"));
  list.Filter("1.000");
  EXPECT_THAT(Names(list), ElementsAre()) << "Numbers are not searched.";
  EXPECT_EQ(list.Selected(), nullptr);
  list.Filter("");
  EXPECT_EQ(list.shown().size(), 3U);
}

TEST(TopList, KeepsTheSelectedRowWhenTheOrderChanges) {
  TopList list(TopKind::kChannels);
  list.Show({ChannelRow("a", 3), ChannelRow("b", 2), ChannelRow("c", 1)});
  list.Move(1);
  EXPECT_EQ(list.Selected()->channel, "b");
  list.Show({ChannelRow("a", 3), ChannelRow("b", 9), ChannelRow("c", 1)});
  EXPECT_EQ(list.Selected()->channel, "b");
  list.Show({ChannelRow("a", 3), ChannelRow("c", 1)});
  ASSERT_NE(list.Selected(), nullptr);
  list.Move(-10);
  list.Show({ChannelRow("a", 3), ChannelRow("c", 10)});
  EXPECT_EQ(list.Selected()->channel, "c") << "The first row stays the first.";
}

TEST(TopList, HoldsTheSelectedRowInTheWindow) {
  TopList list(TopKind::kChannels);
  std::vector<TopRow> rows;
  for (int i = 0; i < 20; ++i) rows.push_back(ChannelRow("c" + std::to_string(i), 100 - i));
  list.Show(rows);
  EXPECT_EQ(list.FirstInWindow(5), 0U);
  list.Move(4);
  EXPECT_EQ(list.FirstInWindow(5), 0U);
  list.Move(1);
  EXPECT_EQ(list.FirstInWindow(5), 1U);
  list.Move(1000);
  EXPECT_EQ(list.FirstInWindow(5), 15U);
  EXPECT_EQ(list.FirstInWindow(50), 0U);
  EXPECT_EQ(list.FirstInWindow(1), 19U);
  list.Show({});
  EXPECT_EQ(list.FirstInWindow(5), 0U);
}

TEST(ColumnWidths, NarrowTextsFirstAndThenLeaveOutTheLastColumns) {
  const std::vector<Column> columns{{"a", "A"}, {"b", ""}, {"c", "C", true}, {"d", "D"}, {"e", "E", true}};
  EXPECT_THAT(ColumnWidths(columns, {30, 5, 8, 20, 8}, 100), ElementsAre(30, 0, 8, 20, 8));
  EXPECT_THAT(ColumnWidths(columns, {30, 5, 8, 20, 8}, 62), ElementsAre(20, 0, 8, 20, 8));
  EXPECT_THAT(ColumnWidths(columns, {30, 5, 8, 20, 8}, 45), ElementsAre(16, 0, 8, 17, 0));
  EXPECT_THAT(ColumnWidths(columns, {30, 5, 8, 20, 8}, 10), ElementsAre(10, 0, 0, 0, 0));
  EXPECT_THAT(ColumnWidths(columns, {1'000'000'000, 5, 8, 20, 8}, 40), ElementsAre(14, 0, 8, 14, 0));
}

}  // namespace
}  // namespace hgros::cli
