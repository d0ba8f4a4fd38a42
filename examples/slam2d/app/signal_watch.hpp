#pragma once

#include <functional>
#include <thread>

namespace slam2d {

/// Calls `on_signal` on a thread of its own at SIGINT and SIGTERM, instead of what they would do.
///
/// To be made before any other thread: threads inherit that they leave these signals alone. A second signal ends the
/// process at once, should the end hang.
class SignalWatch {
 public:
  explicit SignalWatch(std::function<void(int)> on_signal);
  SignalWatch(const SignalWatch&) = delete;
  SignalWatch& operator=(const SignalWatch&) = delete;
  ~SignalWatch();

 private:
  std::thread thread_;
};

}  // namespace slam2d
