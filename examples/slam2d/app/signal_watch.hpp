#pragma once

#include <functional>
#include <thread>

namespace slam2d {

/// Calls `on_signal` on its own thread at SIGINT and SIGTERM, instead of their default actions.
///
/// Create it before any other thread, because threads inherit the block of these signals. A second signal ends the
/// process at once, in case the shutdown hangs.
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
