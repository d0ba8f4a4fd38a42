#pragma once

#include <memory>
#include <optional>
#include <stop_token>

#include "hgros/base/export.hpp"
#include "hgros/clock/clock.hpp"
#include "hgros/clock/periodic_schedule.hpp"

namespace hgros {

/// Runs a loop at a fixed rate of a clock: `while (rate.Sleep()) { ... }`.
///
/// The first period starts with the object. The rate does not drift. Jumps of the clock do not change it; a pause
/// delays it. Thread safety: none; each loop has its own.
class HGROS_EXPORT Rate {
 public:
  /// Throws Error unless `period` is positive.
  Rate(std::shared_ptr<Clock> clock, Duration period, Missed policy = Missed::kSkip);

  /// Sleeps until the next turn; returns at once if that has passed. Empty if `stop` is requested first.
  [[nodiscard]] std::optional<Tick> Sleep(const std::stop_token& stop = {});

 private:
  Rate(std::shared_ptr<Clock> clock, const ClockReading& begin, Duration period, Missed policy);

  std::shared_ptr<Clock> clock_;
  PeriodicSchedule schedule_;
};

}  // namespace hgros
