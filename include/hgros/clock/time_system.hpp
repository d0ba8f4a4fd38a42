#pragma once

#include <memory>

#include "hgros/base/export.hpp"
#include "hgros/clock/derived_clocks.hpp"
#include "hgros/clock/system_clocks.hpp"

namespace hgros {

/// The paper's time system: the real time and the time since a reference. Thread-safe.
class HGROS_EXPORT TimeSystem {
 public:
  /// The relative time starts at 0 now and runs along `source`, or a steady clock if there is none.
  explicit TimeSystem(std::shared_ptr<Clock> source = nullptr)
      : relative_(std::make_shared<RelativeClock>(std::move(source))) {}

  /// The relative time is `base` plus the time elapsed from now; 0 gives the paper's form. Accepts any unit of
  /// std::chrono.
  void SetBaseTime(Duration base) { relative_->SetBaseTime(base); }
  /// The system's wall clock.
  [[nodiscard]] Time GetRealTime() const { return real_->Now(); }
  [[nodiscard]] Time GetRelativeTime() const { return relative_->Now(); }

  /// Both times as clocks, for sleeping and timers.
  [[nodiscard]] const std::shared_ptr<SystemClock>& real_clock() const noexcept { return real_; }
  [[nodiscard]] const std::shared_ptr<RelativeClock>& relative_clock() const noexcept { return relative_; }

 private:
  std::shared_ptr<SystemClock> real_ = std::make_shared<SystemClock>();
  std::shared_ptr<RelativeClock> relative_;
};

}  // namespace hgros
