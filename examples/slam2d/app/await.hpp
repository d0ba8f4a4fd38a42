#pragma once

#include <algorithm>
#include <chrono>
#include <stop_token>

namespace slam2d {

/// Calls `wait(timeout)`, which cannot be stopped from outside, with short timeouts until it returns true, `deadline`
/// passes or a stop is requested.
template <class Wait>
[[nodiscard]] bool AwaitUnlessStopped(const std::stop_token& stop, std::chrono::steady_clock::time_point deadline,
                                      Wait wait) {
  constexpr std::chrono::nanoseconds kSlice = std::chrono::milliseconds(200);
  while (!stop.stop_requested()) {
    const std::chrono::nanoseconds left = deadline - std::chrono::steady_clock::now();
    if (wait(std::clamp(left, std::chrono::nanoseconds{0}, kSlice))) return true;
    if (left <= std::chrono::nanoseconds{0}) return false;
  }
  return false;
}

}  // namespace slam2d
