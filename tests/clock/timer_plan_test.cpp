#include "clock/timer_plan.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

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

}  // namespace
}  // namespace hgros
