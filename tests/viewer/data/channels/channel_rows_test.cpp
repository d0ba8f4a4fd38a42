#include <gtest/gtest.h>

#include "viewer/data/channels/channel_rates.hpp"
#include "viewer/data/channels/channel_table.hpp"
#include "viewer/data/channels/type_conflict.hpp"

namespace hgros::viewer {
namespace {

using namespace std::chrono_literals;

constexpr std::int64_t kMillisecond = 1'000'000;

MessageInfo Info(std::uint64_t sequence, std::uint64_t incarnation = 1) {
  MessageInfo info;
  info.id = {9, incarnation, sequence};
  info.remote = true;
  return info;
}

TEST(ViewerChannelRates, ReportRateBandwidthAndLatency) {
  ChannelRate rate;
  for (int i = 0; i < 21; ++i) {
    MessageInfo info = Info(static_cast<std::uint64_t>(i + 1));
    info.publish_time_ns = 1'000'000 * kMillisecond + i * 100 * kMillisecond;
    rate.Add(info, 1000, i * 100 * kMillisecond, info.publish_time_ns + 3 * kMillisecond);
  }
  const auto figures = rate.At(2000 * kMillisecond);
  EXPECT_NEAR(figures.messages_per_second, 10, 1e-6);
  EXPECT_NEAR(figures.bytes_per_second, 10'000, 1e-3);
  EXPECT_EQ(figures.latency, std::chrono::milliseconds(3));
  EXPECT_EQ(figures.jitter, std::chrono::nanoseconds(0));
  EXPECT_EQ(figures.messages, 21U);
  EXPECT_EQ(figures.missed, 0U);
  EXPECT_EQ(figures.silence, std::chrono::nanoseconds(0));
}

TEST(ViewerChannelRates, RateOfAStoppedChannelFallsToZero) {
  ChannelRate rate;
  for (int i = 0; i < 11; ++i) rate.Add(Info(static_cast<std::uint64_t>(i + 1)), 1, i * 100 * kMillisecond, 0);
  EXPECT_NEAR(rate.At(1050 * kMillisecond).messages_per_second, 10, 0.1);
  EXPECT_LT(rate.At(3000 * kMillisecond).messages_per_second, 5);
  EXPECT_EQ(rate.At(60'000 * kMillisecond).messages_per_second, 0);
  EXPECT_EQ(rate.At(60'000 * kMillisecond).silence, std::chrono::seconds(59));
}

TEST(ViewerChannelRates, CountsSequenceGapsButNotRestarts) {
  ChannelRate rate;
  for (const std::uint64_t sequence : {5U, 6U, 9U}) rate.Add(Info(sequence), 1, 0, 0);
  EXPECT_EQ(rate.At(0).missed, 2U);
  rate.Add(Info(1, 2), 1, 0, 0);
  rate.Add(Info(2, 2), 1, 0, 0);
  EXPECT_EQ(rate.At(0).missed, 2U);
}

TEST(ViewerChannelRates, HasNoFiguresWithoutMessages) {
  const ChannelRate rate;
  EXPECT_EQ(rate.At(5).messages_per_second, 0);
  EXPECT_FALSE(rate.At(5).latency);
  EXPECT_FALSE(rate.At(5).silence);
}

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

ChannelUser User(const std::string& process, const std::string& type, std::uint64_t fingerprint) {
  ChannelUser user;
  user.process = process;
  user.type_name = type;
  user.fingerprint = fingerprint;
  return user;
}

TEST(TypeConflict, IsEmptyIfAllUseOneType) {
  KnownChannel channel{"scan", "Scan", {}, 7, {User("robot", "Scan", 7)}, {User("viewer", "Scan", 7)}};
  EXPECT_EQ(TypeConflict(channel), "");
  channel.subscribers.push_back(User("recorder", "", 0));
  EXPECT_EQ(TypeConflict(channel), "") << "it accepts any type";
  channel.subscribers.push_back(User("echo", "Scan", 0));
  EXPECT_EQ(TypeConflict(channel), "") << "its version is unknown";
  EXPECT_EQ(TypeConflict({}), "");
}

TEST(TypeConflict, NamesTypesAndTheirUsers) {
  const KnownChannel channel{
      "scan", "Scan", {}, 7, {User("robot", "Scan", 7)}, {User("viewer", "Grid", 9), User("other", "Scan", 7)}};
  EXPECT_EQ(TypeConflict(channel),
            "Its users do not agree on the type: Grid is subscribed to by viewer; Scan is published by robot, and "
            "subscribed to by other. No messages pass between different types.");
}

TEST(TypeConflict, DistinguishesSchemasWithTheSameName) {
  const KnownChannel channel{"scan", "Scan", {}, 7, {User("robot", "Scan", 7)}, {User("viewer", "Scan", 9)}};
  EXPECT_EQ(TypeConflict(channel),
            "Its users do not agree on the type: Scan (schema 0000000000000007) is published by robot; Scan "
            "(schema 0000000000000009) is subscribed to by viewer. Messages pass only between compatible schemas.");
}

TEST(TypeConflict, NamesOnlySomeOfManyUsers) {
  KnownChannel channel{"scan", "Scan", {}, 7, {User("robot", "Grid", 7)}, {}};
  for (int i = 0; i < 9; ++i) channel.subscribers.push_back(User("viewer " + std::to_string(i), "Scan", 9));
  EXPECT_NE(TypeConflict(channel).find("viewer 0, viewer 1, viewer 2, viewer 3 and 5 more"), std::string::npos);
}

}  // namespace
}  // namespace hgros::viewer
