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

}  // namespace hgros
