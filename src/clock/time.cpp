#include "hgros/clock/time.hpp"

#include <ctime>
#include <limits>

namespace hgros {
namespace {

std::int64_t Read(clockid_t id) noexcept {
  timespec now{};
  clock_gettime(id, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

}  // namespace

Time Later(Time t, Duration d) noexcept {
  std::int64_t sum = 0;
  if (!__builtin_add_overflow(t.nanoseconds, d.count(), &sum)) return {sum};
  return d.count() > 0 ? Time::Never() : Time{std::numeric_limits<std::int64_t>::min()};
}

Time WallNow() noexcept { return {Read(CLOCK_REALTIME)}; }

std::int64_t MonotonicNow() noexcept { return Read(CLOCK_MONOTONIC); }

std::chrono::steady_clock::time_point DeadlineIn(std::chrono::nanoseconds timeout) noexcept {
  using Steady = std::chrono::steady_clock;
  const Steady::time_point now = Steady::now();
  return timeout > Steady::time_point::max() - now ? Steady::time_point::max() : now + timeout;
}

}  // namespace hgros
