#include "graph/channel/publish_rate.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

namespace hgros {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

class PublishRateTest : public testing::Test {
 protected:
  // Publishes this number of messages with this period.
  void Publish(int count, std::int64_t period) {
    for (int i = 0; i < count; ++i) rate.Note(++sequence, now += period);
  }
  [[nodiscard]] double HertzAfter(std::int64_t time) const { return rate.Hertz(sequence, now + time); }

  PublishRate rate;
  std::uint64_t sequence = 0;
  std::int64_t now = 5 * kSecond;
};

TEST_F(PublishRateTest, IsThatOfTheLastMessages) {
  EXPECT_EQ(HertzAfter(0), 0);
  Publish(1, 0);
  EXPECT_EQ(HertzAfter(0), 0);
  Publish(1, kSecond / 10);
  EXPECT_DOUBLE_EQ(HertzAfter(0), 10);
  Publish(1000, kSecond / 100);
  EXPECT_NEAR(HertzAfter(0), 100, 1e-6);
  Publish(60, kSecond / 20);  // 3 s at another rate.
  EXPECT_NEAR(HertzAfter(0), 20, 1e-6);
}

TEST_F(PublishRateTest, IsSteadyForSlowChannels) {
  Publish(1, 10 * kSecond);
  for (int i = 1; i < 100; ++i) {
    Publish(1, 10 * kSecond);
    EXPECT_NEAR(HertzAfter(9 * kSecond), 0.1, 1e-9) << i;
  }
}

TEST_F(PublishRateTest, FallsWhenNoMessageComes) {
  Publish(300, kSecond / 100);
  EXPECT_NEAR(HertzAfter(kSecond / 100), 100, 1e-6);
  EXPECT_LT(HertzAfter(kSecond), 90);
  EXPECT_NEAR(HertzAfter(10 * kSecond), 0.1, 1e-9);  // A sensor that died must not look alive.
  EXPECT_NEAR(HertzAfter(1000 * kSecond), 0.001, 1e-9);
}

TEST(PublishRate, IsRightAfterSeveralThreadsHavePublished) {
  PublishRate rate;
  std::atomic<std::uint64_t> sequence{0};
  const auto time_of = [](std::uint64_t count) {
    return kSecond + static_cast<std::int64_t>(count) * (kSecond / 1000);
  };
  rate.Note(++sequence, time_of(1));  // A thread that is interrupted while it reads keeps others from noting the first.
  std::vector<std::thread> threads;
  for (int t = 0; t < 3; ++t) {
    threads.emplace_back([&] {
      for (int i = 0; i < 20000; ++i) {
        const std::uint64_t count = ++sequence;
        rate.Note(count, time_of(count));
      }
    });
  }
  for (int i = 0; i < 2000; ++i) {
    const std::uint64_t count = sequence;
    const double hertz = rate.Hertz(count, time_of(count));
    EXPECT_GE(hertz, 0);
    EXPECT_LE(count > 1000 ? hertz : 0, 10'000);
  }
  for (std::thread& thread : threads) thread.join();
  // A thread that was interrupted before it noted its message may have noted an old one last. The next one mends that.
  const std::uint64_t count = ++sequence;
  rate.Note(count, time_of(count));
  EXPECT_NEAR(rate.Hertz(sequence, time_of(sequence)), 1000, 10);
}

}  // namespace
}  // namespace hgros
