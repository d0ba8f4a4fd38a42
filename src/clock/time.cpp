#include "hgros/clock/time.hpp"

#include <ctime>

namespace hgros {
namespace {

std::int64_t Read(clockid_t id) noexcept {
  timespec now{};
  clock_gettime(id, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

}  // namespace

Time WallNow() noexcept { return {Read(CLOCK_REALTIME)}; }

std::int64_t MonotonicNow() noexcept { return Read(CLOCK_MONOTONIC); }

std::chrono::steady_clock::time_point DeadlineIn(std::chrono::nanoseconds timeout) noexcept {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point now = Clock::now();
  return timeout > Clock::time_point::max() - now ? Clock::time_point::max() : now + timeout;
}

}  // namespace hgros
