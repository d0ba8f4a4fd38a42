#include "clock/timer_plan.hpp"

namespace hgros {

Time TimerPlan::Entry::due() const {
  if (const auto* const schedule = std::get_if<PeriodicSchedule>(&when)) return schedule->next();
  return std::get<Moment>(when).due;
}

void TimerPlan::Follow(const ClockReading& reading) {
  const Duration jump = reading.jumped - jumped_;
  if (jump == Duration::zero()) return;
  jumped_ = reading.jumped;
  order_.clear();
  for (auto& [id, entry] : entries_) {
    if (auto* const schedule = std::get_if<PeriodicSchedule>(&entry.when)) {
      schedule->Follow(reading);
    } else if (auto& moment = std::get<Moment>(entry.when); moment.moves_along) {
      moment.due = Later(moment.due, jump);
    }
    order_.emplace(entry.due(), id);
  }
}

TimerPlan::Id TimerPlan::Add(Entry entry) {
  const Id id = next_id_++;
  order_.emplace(entry.due(), id);
  entries_.emplace(id, std::move(entry));
  return id;
}

TimerPlan::Id TimerPlan::AddPeriodic(PeriodicSchedule schedule, Callback callback) {
  return Add({schedule, std::move(callback)});
}

TimerPlan::Id TimerPlan::AddOnce(Time due, bool moves_along, Callback callback) {
  return Add({Moment{due, moves_along}, std::move(callback)});
}

std::optional<TimerPlan::Due> TimerPlan::PopDue(const ClockReading& reading) {
  if (order_.empty() || order_.begin()->first > reading.now) return std::nullopt;
  const auto [planned, id] = *order_.begin();
  const auto found = entries_.find(id);
  Entry& entry = found->second;
  Due due{entry.callback, {planned, reading.now, 0}};
  auto* const schedule = std::get_if<PeriodicSchedule>(&entry.when);
  const std::optional<Tick> tick = schedule != nullptr ? schedule->AdvanceTo(reading) : std::nullopt;
  order_.erase(order_.begin());
  if (tick) {
    due.tick = *tick;
    order_.emplace(entry.due(), id);
  } else {
    entries_.erase(found);
  }
  return due;
}

bool TimerPlan::Remove(Id id) {
  const auto found = entries_.find(id);
  if (found == entries_.end()) return false;
  order_.erase({found->second.due(), id});
  entries_.erase(found);
  return true;
}

}  // namespace hgros
