#include "viewer/data/channels/channel_table.hpp"

#include <gtest/gtest.h>

namespace hgros::viewer {
namespace {

using namespace std::chrono_literals;

ChannelLine Line(const std::string& name, std::optional<double> rate = std::nullopt) {
  ChannelLine line;
  line.name = name;
  if (rate) {
    line.figures.emplace();
    line.figures->messages_per_second = *rate;
  }
  return line;
}

std::string Names(const std::vector<ChannelLine>& lines) {
  std::string names;
  for (const ChannelLine& line : lines) names += line.name;
  return names;
}

TEST(ViewerChannelTable, NamesEachProgramOnce) {
  KnownChannel channel;
  channel.name = "scan";
  channel.type_name = "foxglove.LaserScan";
  for (const char* process : {"slam", "lidar", "lidar"}) channel.publishers.emplace_back().process = process;
  const ChannelLine line = MakeChannelLine(channel);
  EXPECT_EQ(line.publishers, "lidar x 2, slam");
  EXPECT_EQ(line.subscribers, "");
  EXPECT_FALSE(line.figures);
}

TEST(ViewerChannelTable, SortsUnmeasuredChannelsLastInBothDirections) {
  std::vector<ChannelLine> lines{Line("a"), Line("b", 5), Line("c", 10), Line("d")};
  SortLines(lines, ChannelColumn::kRate, true);
  EXPECT_EQ(Names(lines), "cbad");
  SortLines(lines, ChannelColumn::kRate, false);
  EXPECT_EQ(Names(lines), "bcad");
}

TEST(ViewerChannelTable, SortsEqualRowsByName) {
  std::vector<ChannelLine> lines{Line("c", 5), Line("a", 5), Line("b", 5)};
  SortLines(lines, ChannelColumn::kRate, true);
  EXPECT_EQ(Names(lines), "abc");
  SortLines(lines, ChannelColumn::kName, true);
  EXPECT_EQ(Names(lines), "cba");
}

TEST(ViewerChannelTable, SortsBySilence) {
  std::vector<ChannelLine> lines{Line("a", 1), Line("b", 1), Line("c", 1)};
  lines[0].figures->silence = 2s;
  lines[1].figures->silence = 1s;
  SortLines(lines, ChannelColumn::kAge, false);
  EXPECT_EQ(Names(lines), "bac") << "a channel without messages has no age";
}

}  // namespace
}  // namespace hgros::viewer
