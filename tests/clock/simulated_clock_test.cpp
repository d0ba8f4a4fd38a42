#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/clock/derived_clocks.hpp"
#include "support/await.hpp"

namespace hgros {
namespace {

using namespace std::chrono_literals;

TEST(SimulatedClock, RunsAtItsRate) {
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
}

TEST(SimulatedClock, StandsWhilePausedAndContinuesWithoutAJump) {
  const auto source = SimulatedClock::Paused();
  SimulatedClock clock({}, source);
  source->Step(1s);
  clock.Pause();
  EXPECT_TRUE(clock.paused());
  source->Step(1h);
  EXPECT_EQ(clock.Now(), Time{} + 1s);
  clock.Resume();
  EXPECT_EQ(clock.Now(), Time{} + 1s);
  source->Step(1s);
  EXPECT_EQ(clock.Now(), Time{} + 2s);
}

TEST(SimulatedClock, StepsWhilePausedAndWhileRunning) {
  const auto source = SimulatedClock::Paused();
  SimulatedClock clock({}, source);
  clock.Step(5s);
  EXPECT_EQ(clock.Now(), Time{} + 5s);
  clock.Pause();
  clock.Step(1s);
  EXPECT_EQ(clock.Now(), Time{} + 6s);
  EXPECT_EQ(clock.Read().jumped, 0s);
}

TEST(SimulatedClock, DoesNotFollowTheJumpsOfItsSource) {
  const auto source = SimulatedClock::Paused(Time{} + 100s);
  SimulatedClock clock({}, source);
  source->JumpTo(Time{} + 500s);
  EXPECT_EQ(clock.Now(), Time{});
  source->Step(1s);
  source->JumpTo(Time{});
  EXPECT_EQ(clock.Now(), Time{} + 1s);
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

TEST(SleepUntil, EndsWhenASteppedClockShowsTheMoment) {
  const auto clock = SimulatedClock::Paused();
  std::atomic<bool> awake{false};
  std::jthread sleeping([&] {
    EXPECT_TRUE(SleepUntil(*clock, Time{} + 10s));
    EXPECT_EQ(clock->Now(), Time{} + 10s);
    awake = true;
  });
  clock->Step(9s);
  clock->Step(1s - 1ns);
  EXPECT_FALSE(awake);
  clock->Step(1ns);
  sleeping.join();
}

TEST(SleepUntil, EndsWhenTheClockJumpsBeyondTheMoment) {
  const auto clock = SimulatedClock::Paused();
  std::jthread sleeping([&] { EXPECT_TRUE(SleepUntil(*clock, Time{} + 10s)); });
  clock->JumpTo(Time{} + 11s);
  sleeping.join();
}

TEST(SleepUntil, LastsLongerWhenTheClockJumpsBack) {
  const auto clock = SimulatedClock::Paused(Time{} + 5s);
  std::atomic<bool> awake{false};
  std::jthread sleeping([&] {
    EXPECT_TRUE(SleepUntil(*clock, Time{} + 10s));
    awake = true;
  });
  clock->JumpTo(Time{} + 1s);
  clock->Step(6s);
  EXPECT_FALSE(awake);
  clock->Step(3s);
  sleeping.join();
}

TEST(SleepUntil, EndsAfterAPausedClockResumes) {
  const auto clock = SimulatedClock::Paused();
  std::jthread sleeping([&] { EXPECT_TRUE(SleepUntil(*clock, Time{} + 1h)); });
  clock->SetRate(1e6);
  clock->Resume();
  sleeping.join();
}

TEST(SleepUntil, EndsOnAStopRequest) {
  const auto clock = SimulatedClock::Paused();
  std::jthread sleeping([&](const std::stop_token& stop) { EXPECT_FALSE(SleepUntil(*clock, Time::Never(), stop)); });
  sleeping.request_stop();
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
