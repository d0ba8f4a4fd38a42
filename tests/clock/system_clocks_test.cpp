#include "hgros/clock/system_clocks.hpp"

#include <gtest/gtest.h>
#include <sys/eventfd.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "clock/lines.hpp"
#include "clock/wall_jump_watch.hpp"
#include "clock/wall_offset.hpp"
#include "hgros/base/error.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/clock/time_system.hpp"
#include "hgros/clock/timer_queue.hpp"
#include "support/await.hpp"
#include "support/few_descriptors.hpp"

namespace hgros {
namespace {

using namespace std::chrono_literals;

TEST(WallOffset, CountsLeapsAsJumpsAndIgnoresNoise) {
  WallOffset offset(Time{1'000'000'000}, Time{0});
  EXPECT_EQ(offset.Correct(Time{} + 2s + 900us, Time{} + 1s).jumped, 0s);
  EXPECT_EQ(offset.Correct(Time{} + 3s - 900us, Time{} + 2s).jumped, 0s);
  const ClockReading ahead = offset.Correct(Time{} + 3604s, Time{} + 3s);
  EXPECT_EQ(ahead.jumped, 3600s);
  EXPECT_EQ(ahead.elapsed(), Time{} + 4s);
  EXPECT_EQ(offset.Correct(Time{} + 5s, Time{} + 4s).jumped, 0s);
  EXPECT_EQ(offset.Correct(Time{} + 1s, Time{} + 5s).jumped, -5s);
}

TEST(WallJumpWatch, CallsBackWhenTheClockWasSet) {
  std::atomic<int> set{0};
  OwnDescriptor timer([] { return eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC); });
  const int fd = timer.get();
  WallJumpWatch watch(std::move(timer), [&] { ++set; });
  for (int i = 1; i <= 3; ++i) {
    ASSERT_EQ(eventfd_write(fd, 1), 0);
    ASSERT_TRUE(test::Await([&] { return set == i; }));
  }
}

TEST(SystemClock, WorksUnwatchedUntilItCanBeWatched) {
  test::Lines lines;
  const auto clock = std::make_shared<SystemClock>(lines.Sink());
  std::atomic<int> turns{0};
  std::optional<TimerQueue> timers;
  Timer timer;
  {
    const test::FewDescriptors none(0);
    EXPECT_THROW((void)clock->OnJump([](const ClockJump&) {}), Error);
    timers.emplace(clock);
    timer = timers->Every(1ms, [&](const Tick&) { ++turns; });
    EXPECT_TRUE(test::Await([&] { return turns >= 20; }));
    EXPECT_TRUE(SleepUntil(*clock, clock->Now() + 5ms));
    Sleeper sleeper;
    const ClockReading reading = clock->Read();
    clock->Wait(sleeper, reading,
                reading.now + 24h);  // Returns early, so that the waiting thread checks the clock again.
    ASSERT_EQ(lines.all().size(), 1U);
    EXPECT_NE(lines.all()[0].find("The wall clock cannot be watched: Too many open files."), std::string::npos);
  }
  EXPECT_TRUE(test::Await([&] { return lines.all().size() == 2; }));
  EXPECT_EQ(lines.all().back(), "The wall clock is watched again.");
  EXPECT_NO_THROW((void)clock->OnJump([](const ClockJump&) {}));
}

TEST(SystemClock, ShowsTheWallClock) {
  const SystemClock clock;
  const ClockReading reading = clock.Read();
  EXPECT_LE(reading.now, WallNow() + 1s);
  EXPECT_GE(reading.now, WallNow() - 60s);
  EXPECT_EQ(reading.jumped, 0s);
}

template <class C>
class SystemsClocks : public testing::Test {};
using BothClocks = testing::Types<SystemClock, SteadyClock>;
TYPED_TEST_SUITE(SystemsClocks, BothClocks);

TYPED_TEST(SystemsClocks, AcceptListenersAndEndASleepAtItsMoment) {
  TypeParam clock;
  const Listening listening = clock.OnJump([](const ClockJump&) {});
  const Time due = clock.Now() + 5ms;
  EXPECT_TRUE(SleepUntil(clock, due));
  EXPECT_GE(clock.Now(), due);
  EXPECT_TRUE(SleepFor(clock, 1ms));
  EXPECT_TRUE(SleepUntil(clock, due));
  EXPECT_TRUE(SleepUntil(clock, Time{-1}));
}

TYPED_TEST(SystemsClocks, EndASleepThatIsStopped) {
  TypeParam clock;
  for (const Time due : {Time::Never(), clock.Now() + 1h}) {
    std::jthread sleeping([&](const std::stop_token& stop) { EXPECT_FALSE(SleepUntil(clock, due, stop)); });
    sleeping.request_stop();
  }
}

TEST(TimeSystem, ReturnsRealTimeAndTimeSinceAReference) {
  const auto source = SimulatedClock::Paused(Time{} + 50s);
  TimeSystem time(source);
  source->Step(2s);
  EXPECT_EQ(time.GetRelativeTime(), Time{} + 2s);
  time.SetBaseTime(100us);
  EXPECT_EQ(time.GetRelativeTime(), Time{100'000});
  source->Step(3s);
  EXPECT_EQ(time.GetRelativeTime(), Time{100'000} + 3s);
  source->JumpTo(Time{});
  EXPECT_EQ(time.GetRelativeTime(), Time{100'000} + 3s);
  time.SetBaseTime(0ns);
  EXPECT_EQ(time.GetRelativeTime(), Time{0});
  EXPECT_GE(time.GetRealTime(), WallNow() - 60s);
  Time after;
  const Listening listening = time.relative_clock()->OnJump([&](const ClockJump& jump) { after = jump.after; });
  std::jthread sleeping([&] { EXPECT_TRUE(SleepUntil(*time.relative_clock(), Time{} + 1h)); });
  time.SetBaseTime(2h);
  sleeping.join();
  EXPECT_EQ(after, Time{} + 2h) << "a new base is a jump of the relative clock";
}

TEST(Time, AddsComparesSaturatesAndConverts) {
  const Time start{1'000};
  EXPECT_EQ(start + 1us, Time{2'000});
  EXPECT_EQ(start + -1us, Time{0});
  EXPECT_EQ((start + 5s) - start, 5s);
  EXPECT_EQ(start - (start + 5s), -5s);
  EXPECT_LT(Time{1}, Time{2});
  EXPECT_EQ(Time{}, Time{0});
  EXPECT_EQ(Later(Time{5}, 2ns), Time{7});
  EXPECT_EQ(Later(Time{5}, Duration::max()), Time::Never());
  EXPECT_EQ(Later(Time{-5}, Duration::min()).nanoseconds, std::numeric_limits<std::int64_t>::min());
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

TEST(MonotonicNow, IsTheClockOfTheStandardLibrarysIntervalsAndNeverGoesBack) {
  const auto steady_now = [] { return std::chrono::steady_clock::now().time_since_epoch() / 1ns; };
  const std::int64_t before = steady_now();
  std::int64_t last = MonotonicNow();
  EXPECT_LE(before, last);
  EXPECT_LE(last, steady_now());
  for (int i = 0; i < 100'000; ++i) {
    const std::int64_t now = MonotonicNow();
    ASSERT_GE(now, last);
    last = now;
  }
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
