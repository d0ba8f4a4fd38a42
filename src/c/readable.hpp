#pragma once

#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <limits>
#include <system_error>

#include "hgros/base/error.hpp"

namespace hgros::c {

// Waits until a descriptor is readable. False if the deadline came first.
inline bool AwaitReadable(int descriptor, std::chrono::steady_clock::time_point deadline) {
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now()).count();
    const auto most = std::int64_t{std::numeric_limits<int>::max()};
    pollfd one{descriptor, POLLIN, 0};
    const int ready = poll(&one, 1, static_cast<int>(std::clamp<std::int64_t>(left, 0, most)));
    if (ready > 0) return true;
    if (ready < 0 && errno != EINTR) throw Error("poll() has failed: " + std::generic_category().message(errno) + ".");
    if (ready == 0 && left <= 0) return false;
  }
}

}  // namespace hgros::c
