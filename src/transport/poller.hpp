#pragma once

#include <atomic>

namespace hgros {

/// Waits for descriptors with epoll in edge-triggered mode. Each new signal wakes one of the waiting threads once.
///
/// Thread safety: thread-safe; several threads may wait.
class Poller {
 public:
  Poller();
  ~Poller();
  Poller(const Poller&) = delete;
  Poller& operator=(const Poller&) = delete;

  /// From now on Wait() sets `flag` when `fd` has become readable, or is readable already. `flag` outlives the
  /// poller: it may still be set after the descriptor was closed, which removes it. Throws Error.
  void Add(int fd, std::atomic<bool>& flag);
  /// The same, but only the first time. Then the next call waits for it again. False if `fd` cannot be waited for.
  bool AddOnce(int fd, std::atomic<bool>& flag) noexcept;
  /// Returns after setting at least one flag, or after `timeout_ms`, or spuriously.
  void Wait(int timeout_ms) noexcept;

 private:
  int fd_;
};

}  // namespace hgros
