#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <thread>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/clock/derived_clocks.hpp"
#include "hgros/internal/clock/clock_line.hpp"
#include "support/await.hpp"

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

TEST(SimulatedClock, RunsAtItsRateAndDoesNotFollowTheJumpsOfItsSource) {
  const auto source = SimulatedClock::Paused(Time{777});
  SimulatedClock clock(Time{1'000}, source);
  EXPECT_EQ(clock.Now(), Time{1'000});
  source->Step(2s);
  EXPECT_EQ(clock.Now(), Time{1'000} + 2s);
  clock.SetRate(0.5);
  source->Step(2s);
  EXPECT_EQ(clock.Now(), Time{1'000} + 3s);
  clock.SetRate(10);
  source->Step(1s);
  EXPECT_EQ(clock.Now(), Time{1'000} + 13s);
  source->JumpTo(Time{} + 500s);
  EXPECT_EQ(clock.Now(), Time{1'000} + 13s);
  source->Step(1s);
  source->JumpTo(Time{});
  EXPECT_EQ(clock.Now(), Time{1'000} + 23s);
}

TEST(SimulatedClock, StandsWhilePausedStepsAndContinuesWithoutAJump) {
  const auto source = SimulatedClock::Paused();
  SimulatedClock clock({}, source);
  source->Step(1s);
  clock.Step(5s);
  EXPECT_EQ(clock.Now(), Time{} + 6s);
  clock.Pause();
  EXPECT_TRUE(clock.paused());
  source->Step(1h);
  EXPECT_EQ(clock.Now(), Time{} + 6s);
  clock.Step(1s);
  EXPECT_EQ(clock.Now(), Time{} + 7s);
  clock.Resume();
  EXPECT_EQ(clock.Now(), Time{} + 7s);
  source->Step(1s);
  EXPECT_EQ(clock.Now(), Time{} + 8s);
  EXPECT_EQ(clock.Read().jumped, 0s);
}

TEST(SimulatedClock, RefusesInvalidRatesAndStepsBack) {
  SimulatedClock clock;
  EXPECT_THROW(clock.SetRate(0), Error);
  EXPECT_THROW(clock.SetRate(-1), Error);
  EXPECT_THROW(clock.SetRate(std::nan("")), Error);
  EXPECT_THROW(clock.SetRate(INFINITY), Error);
  EXPECT_THROW(clock.SetRate(1e300), Error);
  EXPECT_THROW(clock.Step(-1ns), Error);
  EXPECT_EQ(clock.rate(), 1.0);
}

TEST(SimulatedClock, ReportsItsJumpsToListeners) {
  const auto clock = SimulatedClock::Paused(Time{} + 10s);
  std::vector<Duration> jumps;
  Listening listening = clock->OnJump([&](const ClockJump& jump) {
    EXPECT_EQ(clock->Now(), jump.after);
    jumps.push_back(jump.after - jump.before);
  });
  clock->JumpTo(Time{} + 40s);
  clock->Step(1s);
  clock->JumpTo(Time{} + 1s);
  EXPECT_EQ(jumps, (std::vector<Duration>{30s, -40s}));
  EXPECT_EQ(clock->Read().jumped, -10s);
  listening.Reset();
  clock->JumpTo(Time{});
  EXPECT_EQ(jumps.size(), 2U);
}

TEST(SimulatedClock, AListenerThatThrowsKeepsNobodyAsleep) {
  const auto clock = SimulatedClock::Paused(Time{} + 100s);
  const Listening listening = clock->OnJump([](const ClockJump&) { throw std::runtime_error("jump"); });
  std::jthread sleeping([&] { EXPECT_TRUE(SleepUntil(*clock, Time{} + 110s)); });
  test::Linger(10ms);
  EXPECT_THROW(clock->JumpTo(Time{} + 200s), std::runtime_error);
  EXPECT_EQ(clock->Now(), Time{} + 200s);
  sleeping.join();
}

TEST(SimulatedClock, ListenerMayEndItselfAndJumpAgain) {
  const auto clock = SimulatedClock::Paused();
  int calls = 0;
  Listening listening;
  listening = clock->OnJump([&](const ClockJump&) {
    if (++calls == 1) {
      clock->JumpTo(Time{} + 9s);
    } else {
      listening.Reset();
    }
  });
  clock->JumpTo(Time{} + 1s);
  clock->JumpTo(Time{} + 2s);
  EXPECT_EQ(calls, 2);
}

TEST(SimulatedClock, ReadsMonotonicallyWhileItsRateChanges) {
  SimulatedClock clock;
  std::jthread changing([&](const std::stop_token& stop) {
    for (int i = 1; !stop.stop_requested(); ++i) {
      clock.SetRate(1.0 + (i % 7) * 0.3);
      if (i % 5 == 0) clock.Pause();
      if (i % 5 == 1) clock.Resume();
      clock.Step(Duration(i % 3));
    }
  });
  Time last = clock.Now();
  for (int i = 0; i < 20'000; ++i) {
    const Time now = clock.Now();
    ASSERT_GE(now, last);
    last = now;
  }
}

TEST(SleepUntil, EndsWhenASteppedClockShowsTheMomentAlsoAfterAJumpBack) {
  const auto clock = SimulatedClock::Paused(Time{} + 5s);
  std::atomic<bool> awake{false};
  std::jthread sleeping([&] {
    EXPECT_TRUE(SleepUntil(*clock, Time{} + 10s));
    EXPECT_EQ(clock->Now(), Time{} + 10s);
    awake = true;
  });
  clock->JumpTo(Time{} + 1s);
  clock->Step(8s);
  clock->Step(1s - 1ns);
  EXPECT_FALSE(awake);
  clock->Step(1ns);
  sleeping.join();
}

TEST(SleepFor, DoesNotCountJumps) {
  const auto clock = SimulatedClock::Paused(Time{} + 100s);
  std::atomic<bool> awake{false};
  std::atomic<bool> asleep{false};
  std::jthread sleeping([&] {
    asleep = true;
    EXPECT_TRUE(SleepFor(*clock, 10s));
    awake = true;
  });
  // The sleep may begin before or after the jumps. Both must give the same result.
  ASSERT_TRUE(test::Await([&] { return asleep.load(); }));
  clock->JumpTo(Time{} + 500s);
  clock->JumpTo(Time{});
  EXPECT_FALSE(awake);
  ASSERT_TRUE(test::Await([&] {
    if (!awake) clock->Step(10s);
    return awake.load();
  }));
}

TEST(SleepUntil, WakesManyThreadsThroughJumpsAndPauses) {
  const auto clock = SimulatedClock::Paused();
  constexpr int kThreads = 8;
  constexpr int kRounds = 200;
  std::atomic<int> arrived{0};
  std::vector<std::jthread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&] {
      for (int round = 1; round <= kRounds; ++round) {
        ASSERT_TRUE(SleepUntil(*clock, Time{} + round * 1s));
        ++arrived;
      }
    });
  }
  for (int round = 1; round <= kRounds; ++round) {
    if (round % 3 == 0) {
      clock->JumpTo(Time{} + round * 1s);
    } else {
      clock->Step(1s);
    }
    ASSERT_TRUE(test::Await([&] { return arrived == round * kThreads; })) << "round " << round << ": " << arrived;
  }
}

}  // namespace
}  // namespace hgros
