#include "viewer/data/channels/session_counts.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "viewer/data/cut_text.hpp"

namespace hgros::viewer {
namespace {

constexpr std::int64_t kOneSecond = 1'000'000'000;

Snapshot Told(std::int64_t steady_ns, std::uint64_t published, const std::string& channel = "a") {
  Snapshot snapshot;
  snapshot.set_steady_ns(steady_ns);
  Snapshot::Channel& one = *snapshot.add_channels();
  one.set_name(channel);
  one.set_published(published);
  return snapshot;
}

TEST(SessionCounts, HaveRatesFromTheSecondReportOn) {
  SessionCounts counts;
  EXPECT_EQ(counts.Find(1, "a"), nullptr);
  counts.Add(1, Told(5 * kOneSecond, 10));
  ASSERT_NE(counts.Find(1, "a"), nullptr);
  EXPECT_EQ(counts.Find(1, "a")->published.messages, 10U);
  EXPECT_FALSE(counts.Find(1, "a")->published.per_second);
  counts.Add(1, Told(7 * kOneSecond, 30));
  EXPECT_DOUBLE_EQ(counts.Find(1, "a")->published.per_second.value(), 10);
  EXPECT_EQ(counts.Find(2, "a"), nullptr);
  EXPECT_EQ(counts.Find(1, "b"), nullptr);
}

TEST(SessionCounts, HaveNoRateWhenACountGoesBack) {
  SessionCounts counts;
  counts.Add(1, Told(5 * kOneSecond, 10));
  counts.Add(1, Told(6 * kOneSecond, 3));
  EXPECT_FALSE(counts.Find(1, "a")->published.per_second) << "fewer than before";
  counts.Add(1, Told(6 * kOneSecond, 4));
  EXPECT_FALSE(counts.Find(1, "a")->published.per_second) << "no time has passed";
  counts.Add(1, Told(4 * kOneSecond, 5));
  EXPECT_FALSE(counts.Find(1, "a")->published.per_second) << "its clock went back";
  counts.Add(1, Told(std::numeric_limits<std::int64_t>::max(), 6));
  counts.Add(1, Told(std::numeric_limits<std::int64_t>::min(), 7));
  EXPECT_FALSE(counts.Find(1, "a")->published.per_second) << "its clock went back by the largest difference";
}

TEST(SessionCounts, ForgetSessionsThatAreGone) {
  SessionCounts counts;
  counts.Add(1, Told(kOneSecond, 1));
  counts.Add(2, Told(kOneSecond, 1));
  counts.Add(1, Told(2 * kOneSecond, 1, "b"));
  EXPECT_EQ(counts.Find(1, "a"), nullptr) << "the session no longer has that channel";
  counts.Keep({1});
  EXPECT_NE(counts.Find(1, "b"), nullptr);
  EXPECT_EQ(counts.Find(2, "a"), nullptr);
}

TEST(SessionCounts, AreBoundedForAnyReport) {
  Snapshot snapshot;
  for (std::size_t i = 0; i < SessionCounts::kMaxChannels + 10; ++i) {
    snapshot.add_channels()->set_name("channel" + std::to_string(i));
  }
  Snapshot::Channel& first = *snapshot.mutable_channels(0);
  for (std::size_t i = 0; i < SessionCounts::kMaxNodes + 10; ++i) {
    first.add_nodes()->set_name(std::string(kMaxShownBytes + 100, 'n'));
  }
  SessionCounts counts;
  counts.Add(1, snapshot);
  ASSERT_NE(counts.Find(1, "channel0"), nullptr);
  EXPECT_EQ(counts.Find(1, "channel0")->nodes.size(), SessionCounts::kMaxNodes);
  EXPECT_EQ(counts.Find(1, "channel0")->nodes[0].name.size(), kMaxShownBytes);
  EXPECT_EQ(counts.Find(1, "channel" + std::to_string(SessionCounts::kMaxChannels)), nullptr);
}

}  // namespace
}  // namespace hgros::viewer
