#include "viewer/data/channels/channel_rates.hpp"

#include <gtest/gtest.h>

namespace hgros::viewer {
namespace {

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

}  // namespace
}  // namespace hgros::viewer
