#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <variant>

#include "hgros/clock/clock.hpp"
#include "hgros/clock/periodic_schedule.hpp"
#include "hgros/internal/base/listeners.hpp"

namespace hgros {

// The due times of timers: the state of a TimerQueue without its thread. Adding, taking and removing a timer costs
// O(log n). A jump of the clock costs O(n) in the number of timers that move along with it.
//
// Thread safety: none.
class TimerPlan {
 public:
  using Id = std::uint64_t;  // Grows in the order of adding.
  using Callback = std::shared_ptr<GuardedCallback<const Tick&>>;
  struct Due {
    Callback callback;
    Tick tick;
  };

  // The due time of the next timer as of the latest reading; Time::Never() if there is none.
  [[nodiscard]] Time next() const noexcept { return order_.empty() ? Time::Never() : order_.begin()->first; }
  [[nodiscard]] std::size_t size() const noexcept { return order_.size(); }

  // Shifts timers that run on elapsed time by the jumps since the last reading.
  void Follow(const ClockReading& reading);
  // Call Follow() before each of the next three.
  Id AddPeriodic(PeriodicSchedule schedule, Callback callback);
  Id AddOnce(Time due, bool moves_along, Callback callback);
  // The first timer that is due, if any.
  [[nodiscard]] std::optional<Due> PopDue(const ClockReading& reading);

  // False if the timer is not in the plan: its last turn was taken.
  bool Remove(Id id);

 private:
  struct Moment {
    Time due;
    bool moves_along;
  };
  struct Entry {
    std::variant<PeriodicSchedule, Moment> when;
    Callback callback;
    [[nodiscard]] Time due() const;
  };

  Id Add(Entry entry);

  Id next_id_ = 0;
  Duration jumped_{0};
  std::map<Id, Entry> entries_;
  std::set<std::pair<Time, Id>> order_;
};

}  // namespace hgros
