#pragma once

#include <pybind11/pybind11.h>
#include <unistd.h>

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

/// While it lives, other threads may have the GIL.
///
/// A daemon thread that wants it back while the interpreter ends is ended by Python with pthread_exit(), which would
/// unwind through destructors that need the GIL. Such a thread waits for the end of the process instead.
class GilRelease {
 public:
  GilRelease() noexcept : state_(PyEval_SaveThread()) {}
  GilRelease(const GilRelease&) = delete;
  GilRelease& operator=(const GilRelease&) = delete;
  ~GilRelease() {
    try {
      PyEval_RestoreThread(state_);
    } catch (...) {
      while (true) pause();
    }
  }

 private:
  PyThreadState* const state_;
};

}  // namespace hgros::python
