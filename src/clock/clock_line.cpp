#include "hgros/internal/clock/clock_line.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hgros {
namespace {

// The nearest Duration: casting a value that is too large would be undefined.
Duration Bounded(long double nanoseconds) noexcept {
  constexpr auto kMost = static_cast<long double>(std::numeric_limits<std::int64_t>::max());
  if (nanoseconds >= kMost) return Duration::max();
  if (nanoseconds <= -kMost) return -Duration::max();
  return Duration(static_cast<std::int64_t>(nanoseconds));
}

}  // namespace

Time ClockLine::At(Time source_now) const noexcept {
  Time at = shown;
  if (!paused) {
    const Duration elapsed = source_now - source;
    at = Later(shown, rate == 1.0 ? elapsed : Bounded(std::floor(static_cast<long double>(elapsed.count()) * rate)));
  }
  return std::max(at, least);
}

Time ClockLine::SourceOf(Time due) const noexcept {
  if (due <= shown) return source;
  if (paused || due == Time::Never()) return Time::Never();
  const auto ahead = static_cast<long double>(due.nanoseconds) - static_cast<long double>(shown.nanoseconds);
  return Later(source, Bounded(std::ceil(ahead / rate)));
}

}  // namespace hgros
