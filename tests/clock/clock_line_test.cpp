#include "hgros/internal/clock/clock_line.hpp"

#include <gtest/gtest.h>

#include <random>

namespace hgros {
namespace {

using namespace std::chrono_literals;

TEST(ClockLine, IsExactAtRateOne) {
  const ClockLine line{.source = {1'000}, .shown = {500}};
  EXPECT_EQ(line.At({1'000}), Time{500});
  EXPECT_EQ(line.At({9'000'000'000'000'000'001}), Time{8'999'999'999'999'999'501});
  EXPECT_EQ(line.SourceOf({8'999'999'999'999'999'501}), Time{9'000'000'000'000'000'001});
}

TEST(ClockLine, StandsStillWhilePaused) {
  const ClockLine line{.source = {1'000}, .shown = {500}, .paused = true};
  EXPECT_EQ(line.At({2'000}), Time{500});
  EXPECT_EQ(line.SourceOf({501}), Time::Never());
  EXPECT_EQ(line.SourceOf({500}), Time{1'000});
}

TEST(ClockLine, ReturnsTheFirstMomentAtWhichItShowsATime) {
  constexpr unsigned kSeed = 4;
  std::mt19937_64 random(kSeed);
  for (int i = 0; i < 10'000; ++i) {
    ClockLine line{.source = {std::int64_t(random() >> 8U)}, .shown = {std::int64_t(random() >> 8U)}};
    line.rate = std::uniform_real_distribution(0.01, 100.0)(random);
    const Time due = line.shown + Duration(random() >> 20U);
    const Time source = line.SourceOf(due);
    // Long doubles of 64 bits keep every nanosecond; with fewer the rounding is seen.
    const Duration slack = std::numeric_limits<long double>::digits >= 64 ? 0ns : 128ns;
    ASSERT_GE(line.At(source) + slack, due) << "seed " << kSeed << ", round " << i << ", rate " << line.rate;
    ASSERT_LT(line.At(source - (slack + 1ns)), due) << "seed " << kSeed << ", round " << i << ", rate " << line.rate;
  }
}

TEST(ClockLine, EndsAtTheEndOfTime) {
  const ClockLine line{.source = {0}, .shown = {1'000}, .rate = 1e9};
  EXPECT_EQ(line.At({1'000'000'000'000}), Time::Never());
  EXPECT_EQ(line.SourceOf(Time::Never()), Time::Never());
}

}  // namespace
}  // namespace hgros
