#pragma once

#include <chrono>
#include <compare>
#include <cstdint>
#include <limits>

#include "hgros/base/export.hpp"

namespace hgros {

using Duration = std::chrono::nanoseconds;

/// A point in time: nanoseconds since the Unix epoch, or since the start that a simulation chooses.
struct Time {
  std::int64_t nanoseconds = 0;

  auto operator<=>(const Time&) const = default;  // NOLINT(modernize-use-nullptr): clang-tidy 14 takes its 0 for one
  friend Time operator+(Time t, Duration d) { return {t.nanoseconds + d.count()}; }
  friend Time operator-(Time t, Duration d) { return {t.nanoseconds - d.count()}; }
  friend Duration operator-(Time a, Time b) { return Duration(a.nanoseconds - b.nanoseconds); }

  /// Later than every other time: never.
  [[nodiscard]] static constexpr Time Never() noexcept { return {std::numeric_limits<std::int64_t>::max()}; }
  [[nodiscard]] static Time From(std::chrono::system_clock::time_point t) noexcept {
    return {std::chrono::duration_cast<Duration>(t.time_since_epoch()).count()};
  }
  [[nodiscard]] std::chrono::system_clock::time_point ToSystemClock() const noexcept {
    return std::chrono::system_clock::time_point(Duration(nanoseconds));
  }
};

/// t + d, limited to the end of time.
[[nodiscard]] HGROS_EXPORT Time Later(Time t, Duration d) noexcept;

/// The system's wall clock; it may jump.
[[nodiscard]] HGROS_EXPORT Time WallNow() noexcept;

/// CLOCK_MONOTONIC in ns: for intervals and histograms; never jumps. Comparable between processes of one host.
[[nodiscard]] HGROS_EXPORT std::int64_t MonotonicNow() noexcept;

/// The moment `timeout` from now, limited to the end of time, so that the longest timeout means forever.
[[nodiscard]] HGROS_EXPORT std::chrono::steady_clock::time_point DeadlineIn(std::chrono::nanoseconds timeout) noexcept;

}  // namespace hgros
