#include "hgros/clock/timer_queue.hpp"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include "clock/timer_plan.hpp"
#include "hgros/base/forced_unwind.hpp"
#include "hgros/base/fork_guard.hpp"
#include "hgros/base/system_limits.hpp"

namespace hgros {

// The clock is read under mutex_, and reading may lock the clock. So no clock may call back under its own lock.
class TimerQueue::Core {
 public:
  Core(std::shared_ptr<Clock> clock, LogSink log)
      : clock_(std::move(clock)),
        log_(std::move(log)),
        thread_(StartThread<std::thread>("the thread of the timers", [this] { Loop(); })) {}

  // In a forked child nothing of a queue may be waited for or destroyed.
  [[nodiscard]] bool in_forked_child() const noexcept { return fork_->IsChild(); }

  void Stop() {
    {
      const std::scoped_lock lock(mutex_);
      stopped_ = true;
    }
    sleeper_.Wake();
    thread_.join();
    changed_.notify_all();
  }

  // `add` gets the plan and the reading that the plan has already followed.
  template <class Add>
  Timer AddTimer(const std::shared_ptr<Core>& self, TimerCallback callback, const Add& add, bool waits = true) {
    auto guarded = std::make_shared<GuardedCallback<const Tick&>>(std::move(callback));
    TimerPlan::Id id = 0;
    bool sooner = false;
    {
      const std::scoped_lock lock(mutex_);
      const ClockReading reading = clock_->Read();
      plan_.Follow(reading);
      const Time before = plan_.next();
      id = add(plan_, reading, guarded);
      sooner = plan_.next() < before;
    }
    if (sooner) sleeper_.Wake();
    return Timer([core = std::weak_ptr(self), fork = fork_, id, waits, guarded = std::move(guarded)]() mutable {
      if (fork->IsChild()) return LeaveToParent(std::move(guarded));
      if (const auto there = core.lock()) there->Remove(id);
      if (waits) guarded->Close();
    });
  }

  void Settle() {
    if (std::this_thread::get_id() == thread_.get_id()) return;
    std::unique_lock lock(mutex_);
    const Time until = clock_->Now();
    sleeper_.Wake();
    changed_.wait(lock, [this, until] {
      if (stopped_) return true;
      const ClockReading reading = clock_->Read();
      plan_.Follow(reading);
      return !running_ && plan_.next() > std::min(until, reading.now);
    });
  }

  [[nodiscard]] Time next() {
    const std::scoped_lock lock(mutex_);
    plan_.Follow(clock_->Read());
    return plan_.next();
  }
  [[nodiscard]] std::size_t size() {
    const std::scoped_lock lock(mutex_);
    return plan_.size();
  }
  [[nodiscard]] const std::shared_ptr<Clock>& clock() const noexcept { return clock_; }

 private:
  void Remove(TimerPlan::Id id) {
    {
      const std::scoped_lock lock(mutex_);
      plan_.Remove(id);
    }
    changed_.notify_all();
  }

  void Loop() {
    std::unique_lock lock(mutex_);
    while (!stopped_) {
      const ClockReading reading = clock_->Read();
      plan_.Follow(reading);
      std::optional<TimerPlan::Due> due = plan_.PopDue(reading);
      running_ = due.has_value();
      const Time next = plan_.next();
      lock.unlock();
      if (due) {
        Run(*due);
        due.reset();
      } else {
        changed_.notify_all();
        clock_->Wait(sleeper_, reading, next);
      }
      lock.lock();
      running_ = false;
    }
  }

  void Run(const TimerPlan::Due& due) {
    try {
      due.callback->Call(due.tick);
    } catch (const std::exception& e) {
      log_.WriteLimited(LogLevel::kError, "timer", std::string("A timer's callback threw: ") + e.what());
    } catch (const ForcedUnwind&) {
      EndAfterForcedUnwind(log_, "A timer's callback");
    } catch (...) {
      log_.WriteLimited(LogLevel::kError, "timer", "A timer's callback threw something that is not a std::exception.");
    }
  }

  const std::shared_ptr<const ForkGuard> fork_ = std::make_shared<const ForkGuard>();  // Timers may outlive the queue.
  const std::shared_ptr<Clock> clock_;
  Log log_;
  Sleeper sleeper_;
  std::mutex mutex_;
  std::condition_variable changed_;
  TimerPlan plan_;        // guarded by mutex_
  bool running_ = false;  // guarded by mutex_
  bool stopped_ = false;  // guarded by mutex_
  std::thread thread_;    // last: it uses the rest
};

TimerQueue::TimerQueue(std::shared_ptr<Clock> clock, LogSink log)
    : core_(std::make_shared<Core>(std::move(clock), std::move(log))) {}

TimerQueue::~TimerQueue() {
  if (core_->in_forked_child()) {
    LeaveToParent(std::move(core_));
  } else {
    core_->Stop();
  }
}

Timer TimerQueue::Every(Duration period, TimerCallback callback, const TimerOptions& options) {
  return core_->AddTimer(
      core_, std::move(callback),
      [&](TimerPlan& plan, const ClockReading& seen, const auto& guarded) {
        const Time first = Later(seen.now, options.first.value_or(period));
        return plan.AddPeriodic(PeriodicSchedule(seen, first, period, options.missed), guarded);
      },
      options.waits_at_end);
}

Timer TimerQueue::After(Duration delay, TimerCallback callback) {
  return core_->AddTimer(core_, std::move(callback),
                         [&](TimerPlan& plan, const ClockReading& seen, const auto& guarded) {
                           return plan.AddOnce(Later(seen.now, delay), true, guarded);
                         });
}

Timer TimerQueue::At(Time due, TimerCallback callback) {
  return core_->AddTimer(core_, std::move(callback), [&](TimerPlan& plan, const ClockReading&, const auto& guarded) {
    return plan.AddOnce(due, false, guarded);
  });
}

void TimerQueue::Settle() { core_->Settle(); }
Time TimerQueue::next() const { return core_->next(); }
std::size_t TimerQueue::size() const { return core_->size(); }
const std::shared_ptr<Clock>& TimerQueue::clock() const noexcept { return core_->clock(); }

}  // namespace hgros
