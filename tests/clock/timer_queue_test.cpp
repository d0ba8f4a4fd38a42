#include "hgros/clock/timer_queue.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/clock/derived_clocks.hpp"
#include "hgros/clock/system_clocks.hpp"
#include "support/await.hpp"

namespace hgros {
namespace {

using namespace std::chrono_literals;

constexpr Time kAtZero{};

// A queue on a clock that only the test advances.
class TimerQueueTest : public testing::Test {
 protected:
  void Step(Duration time) {
    clock_->Step(time);
    queue_.Settle();
  }
  void JumpTo(Time time) {
    clock_->JumpTo(time);
    queue_.Settle();
  }
  TimerCallback Noting() {
    return [this](const Tick& tick) { ticks_.push_back(tick); };
  }

  std::vector<Tick> ticks_;
  std::shared_ptr<SimulatedClock> clock_ = SimulatedClock::Paused();
  std::string said_;
  TimerQueue queue_{clock_, [this](LogLevel, std::string_view text) { said_ = text; }};
};

TEST_F(TimerQueueTest, TellsWhenTheNextTimerIsDueAndRefusesAPeriodThatIsNotPositive) {
  EXPECT_THROW((void)queue_.Every(0s, Noting()), Error) << "its period is not positive";
  EXPECT_EQ(queue_.size(), 0U);
  EXPECT_EQ(queue_.next(), Time::Never());
  const Timer every = queue_.Every(100ms, Noting());
  const Timer after = queue_.After(30ms, Noting());
  EXPECT_EQ(queue_.next(), kAtZero + Duration(30ms));
  Step(30ms);
  EXPECT_EQ(queue_.next(), kAtZero + Duration(100ms));
  JumpTo(kAtZero + Duration(1h));
  EXPECT_EQ(queue_.next(), kAtZero + Duration(1h) + Duration(70ms));
}

TEST_F(TimerQueueTest, StartsAtTheRequestedDelay) {
  const Timer timer = queue_.Every(100ms, Noting(), {.first = 0ms});
  queue_.Settle();
  ASSERT_EQ(ticks_.size(), 1U);
  EXPECT_EQ(ticks_[0].planned, kAtZero);
  const Timer long_ago = queue_.At(kAtZero - 1h, Noting());
  queue_.Settle();
  ASSERT_EQ(ticks_.size(), 2U);
  EXPECT_EQ(ticks_[1].planned, kAtZero - 1h);
}

TEST_F(TimerQueueTest, SkipsOrCatchesUpAsConfigured) {
  const Timer skipping = queue_.Every(10ms, Noting());
  Step(55ms);
  ASSERT_EQ(ticks_.size(), 1U);
  EXPECT_EQ(ticks_[0].planned, kAtZero + 50ms);
  EXPECT_EQ(ticks_[0].missed, 4U);
  ticks_.clear();
  std::vector<Time> planned;
  const Timer catching_up =
      queue_.Every(10ms, [&](const Tick& tick) { planned.push_back(tick.planned); }, {.missed = Missed::kCatchUp});
  Step(35ms);
  EXPECT_EQ(planned, (std::vector<Time>{kAtZero + 65ms, kAtZero + 75ms, kAtZero + 85ms}));
}

TEST_F(TimerQueueTest, PauseCausesNoBurst) {
  for (const Missed policy : {Missed::kSkip, Missed::kCatchUp}) {
    const auto source = SimulatedClock::Paused();
    const auto clock = std::make_shared<SimulatedClock>(kAtZero, source);
    TimerQueue queue(clock);
    std::atomic<int> calls{0};
    const Timer timer =
        queue.Every(10ms, [&](const Tick& tick) { calls += 1 + static_cast<int>(tick.missed); }, {.missed = policy});
    source->Step(15ms);
    queue.Settle();
    EXPECT_EQ(calls, 1);
    clock->Pause();
    source->Step(1h);
    queue.Settle();
    EXPECT_EQ(calls, 1);
    clock->Resume();
    source->Step(5ms);
    queue.Settle();
    EXPECT_EQ(calls, 2);
  }
}

TEST_F(TimerQueueTest, JumpsShiftPeriodicTimersAndTriggerTimersSetForAMoment) {
  const Timer every = queue_.Every(10ms, Noting(), {.missed = Missed::kCatchUp});
  std::vector<Time> after_ran;
  const Timer after = queue_.After(15ms, [&](const Tick& tick) { after_ran.push_back(tick.now); });
  std::vector<Time> at_ran;
  const Timer at = queue_.At(kAtZero + 1h, [&](const Tick& tick) { at_ran.push_back(tick.now); });
  Step(4ms);
  JumpTo(kAtZero + 2h);
  EXPECT_TRUE(ticks_.empty());
  EXPECT_EQ(at_ran, std::vector{kAtZero + 2h});
  Step(6ms);
  EXPECT_EQ(ticks_.size(), 1U);
  JumpTo(kAtZero - 2h);
  EXPECT_TRUE(after_ran.empty());
  Step(5ms);
  EXPECT_EQ(after_ran, std::vector{kAtZero - 2h + 5ms});
  Step(5ms);
  ASSERT_EQ(ticks_.size(), 2U);
  EXPECT_EQ(ticks_[1].planned, kAtZero - 2h + 10ms);
}

TEST_F(TimerQueueTest, ItsOwnCallbackOrAnotherThreadMayEndATimer) {
  Timer self;
  Timer other;
  self = queue_.Every(10ms, [&](const Tick&) {
    other = queue_.After(10ms, Noting());
    self.Reset();
  });
  Step(10ms);
  EXPECT_EQ(queue_.size(), 1U);
  Step(10ms);
  EXPECT_EQ(ticks_.size(), 1U);
  Timer outside = queue_.Every(10ms, Noting());
  Step(10ms);
  outside.Reset();
  EXPECT_EQ(queue_.size(), 0U);
  Step(10ms);
  EXPECT_EQ(ticks_.size(), 2U);
}

TEST_F(TimerQueueTest, ThrowingCallbackIsLoggedAndItsTimerContinues) {
  const Timer timer = queue_.Every(10ms, [&](const Tick& tick) {
    ticks_.push_back(tick);
    throw std::runtime_error("no wheel there");
  });
  Step(10ms);
  Step(10ms);
  EXPECT_EQ(ticks_.size(), 2U);
  EXPECT_NE(said_.find("no wheel there"), std::string::npos) << said_;
}

TEST_F(TimerQueueTest, RunsThousandsOfTimers) {
  constexpr int kTimers = 5'000;
  std::vector<Timer> timers;
  std::uint64_t turns = 0;
  for (int i = 0; i < kTimers; ++i) {
    timers.push_back(
        queue_.Every(std::chrono::milliseconds(1 + i % 10), [&](const Tick& t) { turns += 1 + t.missed; }));
  }
  std::uint64_t expected = 0;
  for (unsigned i = 0; i < kTimers; ++i) expected += 20U / (1U + i % 10);
  for (int i = 0; i < 20; ++i) Step(1ms);
  EXPECT_EQ(turns, expected);
}

TEST(TimerQueue, DestroyingATimerWaitsForItsCallback) {
  const auto clock = SimulatedClock::Paused();
  TimerQueue queue(clock);
  test::Door door;
  std::atomic<bool> running{false};
  std::atomic<bool> ended{false};
  Timer timer = queue.After(1ms, [&](const Tick&) {
    running = true;
    door.Pass();
    ended = true;
  });
  clock->Step(1ms);
  ASSERT_TRUE(test::Await([&] { return running.load(); }));
  std::jthread opening([&] { door.Open(); });
  timer.Reset();
  EXPECT_TRUE(ended);
}

TEST(TimerQueue, MayEndBeforeItsTimers) {
  Timer timer;
  {
    TimerQueue queue(std::make_shared<SteadyClock>());
    timer = queue.Every(1h, [](const Tick&) {});
  }
  timer.Reset();
}

TEST(TimerQueue, FollowsTheSystemsClocks) {
  for (const std::shared_ptr<Clock>& clock : {std::shared_ptr<Clock>(std::make_shared<SteadyClock>()),
                                              std::shared_ptr<Clock>(std::make_shared<SystemClock>())}) {
    TimerQueue queue(clock);
    std::atomic<int> turns{0};
    const Timer timer = queue.Every(1ms, [&](const Tick& tick) {
      EXPECT_LE(tick.planned, tick.now);
      turns += 1 + static_cast<int>(tick.missed);
    });
    EXPECT_TRUE(test::Await([&] { return turns >= 20; }));
  }
}

TEST(TimerQueue, SurvivesManyThreadsThatCreateAndEndTimersWhileTheClockJumps) {
  for (const int threads : {1, 2, 4}) {
    const auto clock = std::make_shared<SimulatedClock>();
    TimerQueue queue(clock);
    std::atomic<std::uint64_t> calls{0};
    std::vector<std::jthread> workers;
    for (int t = 0; t < threads; ++t) {
      workers.emplace_back([&, t] {
        std::mt19937 random(static_cast<unsigned>(t));
        std::vector<Timer> timers(10);
        for (int i = 0; i < 300; ++i) {
          const auto in = std::chrono::microseconds(1 + random() % 1000);
          const auto callback = [&](const Tick&) { ++calls; };
          timers[random() % timers.size()] = random() % 2 == 0 ? queue.Every(in, callback) : queue.After(in, callback);
        }
      });
    }
    for (int i = 0; i < 200; ++i) {
      clock->Step(100us);
      if (i % 7 == 0) clock->JumpTo(kAtZero + i * 1ms);
      if (i % 11 == 0) clock->SetRate(1 + i);
    }
    workers.clear();
    EXPECT_EQ(queue.size(), 0U);
  }
}

}  // namespace
}  // namespace hgros
