#include "clock/timer_plan.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <thread>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/clock/derived_clocks.hpp"
#include "hgros/clock/rate.hpp"

namespace hgros {
namespace {

using namespace std::chrono_literals;

// The naive model: checks all timers each time.
struct NaiveTimer {
  TimerPlan::Id id;
  Duration due;     // shown time of absolute timers, elapsed time of others
  Duration period;  // zero: once
  Missed missed;
  bool absolute;
};

struct NaiveRun {
  TimerPlan::Id id;
  Tick tick;
};

class NaivePlan {
 public:
  void Add(NaiveTimer timer) { timers_.push_back(timer); }
  void Remove(TimerPlan::Id id) {
    std::erase_if(timers_, [id](const NaiveTimer& t) { return t.id == id; });
  }
  std::optional<NaiveRun> PopDue(const ClockReading& reading) {
    const auto shown = [&](const NaiveTimer& t) { return Time{} + t.due + (t.absolute ? 0s : reading.jumped); };
    const auto first = std::min_element(timers_.begin(), timers_.end(), [&](const NaiveTimer& a, const NaiveTimer& b) {
      return std::pair(shown(a), a.id) < std::pair(shown(b), b.id);
    });
    if (first == timers_.end() || shown(*first) > reading.now) return std::nullopt;
    NaiveRun run{first->id, {shown(*first), reading.now, 0}};
    if (first->period == 0s) {
      timers_.erase(first);
      return run;
    }
    first->due += first->period;
    while (first->missed == Missed::kSkip && shown(*first) <= reading.now) {
      run.tick.planned = shown(*first);
      ++run.tick.missed;
      first->due += first->period;
    }
    return run;
  }
  [[nodiscard]] const std::vector<NaiveTimer>& timers() const { return timers_; }

 private:
  std::vector<NaiveTimer> timers_;
};

TEST(TimerPlan, AgreesWithANaiveModelUnderRandomStepsAndJumps) {
  for (const unsigned seed : {11U, 12U, 13U, 14U}) {
    std::mt19937 random(seed);
    TimerPlan plan;
    NaivePlan naive;
    ClockReading clock;
    TimerPlan::Id ran = 0;
    const auto callback = [&ran](TimerPlan::Id id) {
      return std::make_shared<GuardedCallback<const Tick&>>([&ran, id](const Tick&) { ran = id; });
    };
    for (TimerPlan::Id id = 0; id < 400;) {
      const auto what = random() % 10;
      const Duration in = std::chrono::milliseconds(static_cast<int>(random() % 200) - 20);
      if (what < 4) {
        const Missed missed = random() % 2 == 0 ? Missed::kSkip : Missed::kCatchUp;
        const Duration period = std::chrono::milliseconds(1 + random() % 100);
        const auto kind = random() % 3;
        plan.Follow(clock);
        if (kind == 0) {
          ASSERT_EQ(plan.AddPeriodic(PeriodicSchedule(clock, clock.now + in, period, missed), callback(id)), id);
          naive.Add({id, clock.elapsed() + in - Time{}, period, missed, false});
        } else {
          ASSERT_EQ(plan.AddOnce(clock.now + in, kind == 1, callback(id)), id);
          const Time due = kind == 1 ? clock.elapsed() + in : clock.now + in;
          naive.Add({id, due - Time{}, 0s, missed, kind == 2});
        }
        ++id;
      } else if (what < 7) {
        clock.now = clock.now + std::chrono::milliseconds(random() % 120);
      } else if (what < 8) {
        const Duration jump = std::chrono::milliseconds(static_cast<int>(random() % 2000) - 1000);
        clock.now = clock.now + jump;
        clock.jumped += jump;
      } else if (!naive.timers().empty()) {
        const TimerPlan::Id victim = naive.timers()[random() % naive.timers().size()].id;
        EXPECT_TRUE(plan.Remove(victim));
        EXPECT_FALSE(plan.Remove(victim));
        naive.Remove(victim);
      }
      plan.Follow(clock);
      for (;;) {
        const std::optional<TimerPlan::Due> due = plan.PopDue(clock);
        const std::optional<NaiveRun> run = naive.PopDue(clock);
        ASSERT_EQ(due.has_value(), run.has_value()) << "seed " << seed << ", timer " << id;
        if (!due) break;
        due->callback->Call(due->tick);
        ASSERT_EQ(ran, run->id) << "seed " << seed;
        ASSERT_EQ(due->tick.planned, run->tick.planned) << "seed " << seed;
        ASSERT_EQ(due->tick.missed, run->tick.missed) << "seed " << seed;
      }
      ASSERT_EQ(plan.size(), naive.timers().size());
    }
  }
}

constexpr Time kZero{};

ClockReading At(Duration now, Duration jumped = 0s) { return {kZero + now, jumped}; }

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
        ASSERT_EQ(tick->now, kZero + elapsed + jumped) << "seed " << seed;
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
