#pragma once

#include <algorithm>
#include <chrono>

namespace hgros::python {

/// More seconds than anybody waits, and few enough for the clocks of the library.
inline constexpr double kLongestWaitS = 1e9;

/// A wait that no signal wakes asks Python for signals this often.
inline constexpr std::chrono::milliseconds kSignalsEvery{20};

/// A wait of Python: 0 if it is negative or not a number, at most kLongestWaitS.
inline std::chrono::nanoseconds Nanoseconds(double seconds) {
  const double bounded = seconds > 0 ? std::min(seconds, kLongestWaitS) : 0;
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(bounded));
}

}  // namespace hgros::python
