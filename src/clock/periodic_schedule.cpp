#include "hgros/clock/periodic_schedule.hpp"

#include <string>

#include "hgros/base/error.hpp"

namespace hgros {

PeriodicSchedule::PeriodicSchedule(const ClockReading& seen, Time first, Duration period, Missed policy)
    : next_(first), period_(period), policy_(policy), jumped_(seen.jumped) {
  if (period > Duration::zero()) return;
  throw Error("A period cannot be " + std::to_string(period.count()) + " ns.", {}, "Use one above zero.");
}

void PeriodicSchedule::Follow(const ClockReading& reading) noexcept {
  next_ = Later(next_, reading.jumped - jumped_);
  jumped_ = reading.jumped;
}

std::optional<Tick> PeriodicSchedule::AdvanceTo(const ClockReading& reading) {
  Follow(reading);
  if (next_ > reading.now || next_ == Time::Never()) return std::nullopt;
  Tick tick{next_, reading.now, 0};
  if (policy_ == Missed::kSkip) {
    const std::int64_t missed = (reading.now - next_) / period_;
    tick.planned = next_ + missed * period_;
    tick.missed = static_cast<std::uint64_t>(missed);
  }
  next_ = Later(tick.planned, period_);
  return tick;
}

}  // namespace hgros
