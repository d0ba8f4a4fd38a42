#include "hgros/clock/rate.hpp"

#include <utility>

namespace hgros {

Rate::Rate(std::shared_ptr<Clock> clock, Duration period, Missed policy) : Rate(clock, clock->Read(), period, policy) {}

Rate::Rate(std::shared_ptr<Clock> clock, const ClockReading& begin, Duration period, Missed policy)
    : clock_(std::move(clock)), schedule_(begin, Later(begin.now, period), period, policy) {}

std::optional<Tick> Rate::Sleep(const std::stop_token& stop) {
  Sleeper sleeper;
  const std::stop_callback wake(stop, [&sleeper] { sleeper.Wake(); });
  for (;;) {
    if (stop.stop_requested()) return std::nullopt;
    const ClockReading reading = clock_->Read();
    if (std::optional<Tick> tick = schedule_.AdvanceTo(reading)) return tick;
    clock_->Wait(sleeper, reading, schedule_.next());
  }
}

}  // namespace hgros
