#pragma once

#include <atomic>

namespace hgros {

/// Waits for descriptors, by epoll in edge-triggered mode: each new signal is told once, to one of the waiting threads.
///
/// Thread safety: all functions; several threads may wait.
class Poller {
 public:
  Poller();
  ~Poller();
  Poller(const Poller&) = delete;
  Poller& operator=(const Poller&) = delete;

  /// From now on Wait() sets `flag` when `fd` has become readable; also if it is so already. `flag` outlives the
  /// poller. Closing the descriptor removes it. Throws Error.
  void Add(int fd, std::atomic<bool>& flag);
  /// Returns after setting at least one flag, or after `timeout_ms`, or earlier for no reason.
  void Wait(int timeout_ms) noexcept;

 private:
  int fd_;
};

}  // namespace hgros
