#include "hgros/clock/rate.hpp"

#include <gtest/gtest.h>

#include <random>
#include <thread>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/clock/derived_clocks.hpp"

namespace hgros {
namespace {

using namespace std::chrono_literals;

constexpr Time kZero{};

ClockReading At(Duration now, Duration jumped = 0s) { return {kZero + now, jumped}; }

TEST(PeriodicSchedule, RunsEachTurnOnceWithoutDrift) {
  PeriodicSchedule schedule(At(0s), kZero + 10ms, 10ms, Missed::kSkip);
  EXPECT_FALSE(schedule.AdvanceTo(At(9ms)));
  const std::optional<Tick> first = schedule.AdvanceTo(At(13ms));
  ASSERT_TRUE(first);
  EXPECT_EQ(first->planned, kZero + 10ms);
  EXPECT_EQ(first->now, kZero + 13ms);
  EXPECT_EQ(first->missed, 0U);
  EXPECT_FALSE(schedule.AdvanceTo(At(13ms)));
  EXPECT_EQ(schedule.next(), kZero + 20ms);
}

TEST(PeriodicSchedule, SkipsAndCountsMissedTurns) {
  PeriodicSchedule schedule(At(0s), kZero + 10ms, 10ms, Missed::kSkip);
  const std::optional<Tick> tick = schedule.AdvanceTo(At(57ms));
  ASSERT_TRUE(tick);
  EXPECT_EQ(tick->planned, kZero + 50ms);
  EXPECT_EQ(tick->missed, 4U);
  EXPECT_EQ(schedule.next(), kZero + 60ms);
}

TEST(PeriodicSchedule, CatchesUpOnMissedTurnsOneByOne) {
  PeriodicSchedule schedule(At(0s), kZero + 10ms, 10ms, Missed::kCatchUp);
  for (int i = 1; i <= 5; ++i) {
    const std::optional<Tick> tick = schedule.AdvanceTo(At(57ms));
    ASSERT_TRUE(tick);
    EXPECT_EQ(tick->planned, kZero + i * 10ms);
    EXPECT_EQ(tick->missed, 0U);
  }
  EXPECT_FALSE(schedule.AdvanceTo(At(57ms)));
}

TEST(PeriodicSchedule, MovesAlongWithJumps) {
  for (const Missed policy : {Missed::kSkip, Missed::kCatchUp}) {
    PeriodicSchedule schedule(At(0s), kZero + 10ms, 10ms, policy);
    EXPECT_FALSE(schedule.AdvanceTo(At(1h + 4ms, 1h)));
    EXPECT_EQ(schedule.next(), kZero + 1h + 10ms);
    EXPECT_FALSE(schedule.AdvanceTo(At(-1h + 9ms, -1h)));
    const std::optional<Tick> tick = schedule.AdvanceTo(At(-1h + 10ms, -1h));
    ASSERT_TRUE(tick);
    EXPECT_EQ(tick->planned, kZero - 1h + 10ms);
    EXPECT_EQ(tick->missed, 0U);
  }
}

TEST(PeriodicSchedule, LosesNoTurnUnderRandomLatenessAndJumps) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    std::mt19937 random(seed);
    PeriodicSchedule schedule(At(0s), kZero + 10ms, 10ms, Missed::kSkip);
    Duration elapsed{0};
    Duration jumped{0};
    std::uint64_t turns = 0;
    for (int i = 0; i < 10'000; ++i) {
      elapsed += Duration(random() % 40'000'000U);
      if (random() % 10 == 0) jumped += std::chrono::milliseconds(static_cast<int>(random() % 20'000U) - 10'000);
      while (const std::optional<Tick> tick = schedule.AdvanceTo(At(elapsed + jumped, jumped))) {
        turns += 1 + tick->missed;
        ASSERT_EQ(tick->planned - jumped, kZero + turns * 10ms) << "seed " << seed;
      }
      ASSERT_EQ(turns, static_cast<std::uint64_t>(elapsed / 10ms)) << "seed " << seed;
    }
  }
}

TEST(PeriodicSchedule, RefusesAPeriodThatIsNotPositive) {
  EXPECT_THROW(PeriodicSchedule(At(0s), kZero, 0s, Missed::kSkip), Error);
  EXPECT_THROW(PeriodicSchedule(At(0s), kZero, -1s, Missed::kSkip), Error);
}

TEST(Rate, KeepsItsRhythmWhenTheLoopIsSlow) {
  const auto clock = SimulatedClock::Paused(kZero + 5s);
  Rate rate(clock, 10ms);
  clock->Step(13ms);
  EXPECT_EQ(rate.Sleep()->planned, kZero + 5s + 10ms);
  clock->Step(8ms);
  EXPECT_EQ(rate.Sleep()->planned, kZero + 5s + 20ms);
  clock->Step(34ms);
  const std::optional<Tick> tick = rate.Sleep();
  EXPECT_EQ(tick->planned, kZero + 5s + 50ms);
  EXPECT_EQ(tick->missed, 2U);
}

TEST(Rate, FollowsItsClockThroughPausesAndJumps) {
  const auto clock = SimulatedClock::Paused();
  std::vector<Tick> ticks;
  std::jthread looping([&] {
    Rate rate(clock, 10ms);
    while (ticks.size() < 3) ticks.push_back(*rate.Sleep());
  });
  clock->JumpTo(kZero + 1h);
  clock->JumpTo(kZero - 1h);
  clock->SetRate(100);
  clock->Resume();
  clock->Pause();
  clock->Resume();
  looping.join();
  EXPECT_EQ(ticks[1].planned - ticks[0].planned, (1 + static_cast<int>(ticks[1].missed)) * 10ms);
  EXPECT_EQ(ticks[2].planned - ticks[1].planned, (1 + static_cast<int>(ticks[2].missed)) * 10ms);
}

TEST(Rate, EndsOnAStopRequest) {
  std::jthread looping([](const std::stop_token& stop) {
    Rate rate(SimulatedClock::Paused(), 10ms);
    EXPECT_FALSE(rate.Sleep(stop));
  });
  looping.request_stop();
}

}  // namespace
}  // namespace hgros
