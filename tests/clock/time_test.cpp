#include "hgros/clock/time.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <limits>

namespace hgros {
namespace {

using namespace std::chrono_literals;

TEST(Time, AddsAndSubtractsDurations) {
  const Time start{1'000};
  EXPECT_EQ(start + 1us, Time{2'000});
  EXPECT_EQ(start + -1us, Time{0});
  EXPECT_EQ((start + 5s) - start, 5s);
  EXPECT_EQ(start - (start + 5s), -5s);
}

TEST(Time, IsOrdered) {
  EXPECT_LT(Time{1}, Time{2});
  EXPECT_EQ(Time{}, Time{0});
}

TEST(Time, SaturatesAtItsLimits) {
  EXPECT_EQ(Later(Time{5}, 2ns), Time{7});
  EXPECT_EQ(Later(Time{5}, Duration::max()), Time::Never());
  EXPECT_EQ(Later(Time{-5}, Duration::min()).nanoseconds, std::numeric_limits<std::int64_t>::min());
}

TEST(Time, IsTheSystemClocksTime) {
  const std::chrono::system_clock::time_point moment(1'700'000'000s);
  EXPECT_EQ(Time::From(moment), Time{1'700'000'000'000'000'000});
  EXPECT_EQ(Time::From(moment).ToSystemClock(), moment);
}

TEST(WallNow, AgreesWithTheSystemClock) {
  const auto system_now = [] {
    return std::chrono::duration_cast<Duration>(std::chrono::system_clock::now().time_since_epoch()).count();
  };
  // A clock that is set between the reads would fail the test; three tries make that unlikely.
  bool agrees = false;
  for (int i = 0; i < 3 && !agrees; ++i) {
    const std::int64_t before = system_now();
    const std::int64_t now = WallNow().nanoseconds;
    agrees = before <= now && now <= system_now();
  }
  EXPECT_TRUE(agrees);
}

TEST(MonotonicNow, NeverGoesBack) {
  std::int64_t last = MonotonicNow();
  for (int i = 0; i < 100'000; ++i) {
    const std::int64_t now = MonotonicNow();
    ASSERT_GE(now, last);
    last = now;
  }
}

TEST(MonotonicNow, IsTheClockOfTheStandardLibrarysIntervals) {
  const auto steady_now = [] { return std::chrono::steady_clock::now().time_since_epoch() / 1ns; };
  const std::int64_t before = steady_now();
  const std::int64_t now = MonotonicNow();
  EXPECT_LE(before, now);
  EXPECT_LE(now, steady_now());
}

TEST(DeadlineIn, KeepsTheLongestTimeoutInTheFuture) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point before = Clock::now();
  EXPECT_EQ(DeadlineIn(std::chrono::nanoseconds::max()), Clock::time_point::max());
  const Clock::time_point deadline = DeadlineIn(2s);
  EXPECT_GE(deadline, before + 2s);
  EXPECT_LE(deadline, Clock::now() + 2s);
  EXPECT_LE(DeadlineIn(-1s), before);
}

}  // namespace
}  // namespace hgros
