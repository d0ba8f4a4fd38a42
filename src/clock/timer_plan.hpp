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

// When which timer is due: what a TimerQueue knows, without its thread. To add, take and remove one costs the logarithm
// of how many there are; a jump of the clock costs all of those that move along with it.
//
// Thread safety: none.
class TimerPlan {
 public:
  using Id = std::uint64_t;  // In the order in which they were added.
  using Callback = std::shared_ptr<GuardedCallback<const Tick&>>;
  struct Due {
    Callback callback;
    Tick tick;
  };

  // Of the latest reading; an empty plan has Time::Never().
  [[nodiscard]] Time next() const noexcept { return order_.empty() ? Time::Never() : order_.begin()->first; }
  [[nodiscard]] std::size_t size() const noexcept { return order_.size(); }

  // Moves along with the jumps since the last reading what is planned by elapsed time.
  void Follow(const ClockReading& reading);
  // Follow() comes before these three.
  Id AddPeriodic(PeriodicSchedule schedule, Callback callback);
  Id AddOnce(Time due, bool moves_along, Callback callback);
  // The first of those that are due.
  [[nodiscard]] std::optional<Due> PopDue(const ClockReading& reading);

  // False if it has run for the last time.
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
