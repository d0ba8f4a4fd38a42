#include "robot/channel_rates.hpp"

#include <gtest/gtest.h>

namespace hgros::cli {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

std::shared_ptr<const Snapshot> Counted(std::int64_t steady_ns, std::uint64_t published, std::uint64_t encoded,
                                        std::uint64_t bytes, double rate_hz = 0) {
  auto snapshot = std::make_shared<Snapshot>();
  snapshot->set_steady_ns(steady_ns);
  Snapshot::Channel& channel = *snapshot->add_channels();
  channel.set_name("scan");
  channel.set_published(published);
  channel.set_encoded(encoded);
  channel.set_encoded_bytes(bytes);
  channel.set_rate_hz(rate_hz);
  return snapshot;
}

KnownChannel Scan(std::vector<std::uint64_t> publishers) {
  KnownChannel channel;
  channel.name = "scan";
  for (const std::uint64_t id : publishers) channel.publishers.emplace_back().session = {id};
  return channel;
}

TEST(ChannelRates, AreThePublishersOwnAsFarAsTheyFitTheDifferences) {
  ChannelRates rates;
  const KnownChannel scan = Scan({1, 2});
  const ChannelRate first =
      rates.Next({{{1}, Counted(5 * kSecond, 100, 0, 0, 7)}, {{2}, Counted(kSecond, 10, 0, 0, 3)}}, scan);
  EXPECT_EQ(first.publishers, 2U);
  EXPECT_EQ(first.rate_hz, 10);
  EXPECT_EQ(first.published, 110U);
  EXPECT_FALSE(first.mean_bytes);
  const ChannelRate then =
      rates.Next({{{1}, Counted(7 * kSecond, 140, 0, 0, 19.9)}, {{2}, Counted(2 * kSecond, 40, 0, 0, 3)}}, scan);
  EXPECT_DOUBLE_EQ(then.rate_hz, 19.9 + 29) << "3 Hz are too few for 30 messages in a second";
  EXPECT_EQ(then.published, 180U);
}

TEST(ChannelRates, OfSlowChannelsStayTheSame) {
  EXPECT_EQ(PublishedRate(0.5, 0, 1), 0.5);
  EXPECT_EQ(PublishedRate(0.5, 1, 1), 0.5);
  EXPECT_EQ(PublishedRate(0.5, 7, 0), 0.5) << "at first";
}

TEST(ChannelRates, FallAtOnceWhenAFastPublisherStops) {
  EXPECT_EQ(PublishedRate(1000, 0, 1), 1);
  EXPECT_EQ(PublishedRate(1000, 500, 1), 501);
}

TEST(ChannelRates, HaveTheMeanSizeOfTheLastIntervalOrElseOfAll) {
  ChannelRates rates;
  const KnownChannel scan = Scan({1});
  EXPECT_EQ(rates.Next({{{1}, Counted(kSecond, 10, 4, 400)}}, scan).mean_bytes, 100);
  EXPECT_EQ(rates.Next({{{1}, Counted(2 * kSecond, 12, 6, 800)}}, scan).mean_bytes, 200);
  EXPECT_EQ(rates.Next({{{1}, Counted(3 * kSecond, 14, 6, 840)}}, scan).mean_bytes, 140);
}

TEST(ChannelRates, LeaveOutAPublisherThatSendsNoMoreCounters) {
  ChannelRates rates;
  const KnownChannel scan = Scan({1});
  const AllCounters counters{{{1}, Counted(kSecond, 10, 0, 0, 7)}};
  for (int i = 0; i < 4; ++i) EXPECT_EQ(rates.Next(counters, scan).rate_hz, 7);
  EXPECT_EQ(rates.Next(counters, scan).publishers, 0U);
  EXPECT_EQ(rates.Next({{{1}, Counted(6 * kSecond, 60, 0, 0, 10)}}, scan).rate_hz, 10);
  EXPECT_EQ(rates.Next({}, scan).publishers, 0U);
}

}  // namespace
}  // namespace hgros::cli
