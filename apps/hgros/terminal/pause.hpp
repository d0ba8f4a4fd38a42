#pragma once

#include <chrono>
#include <functional>

namespace hgros::cli {

/// Where a command waits: until another thread wakes it, a deadline comes, or the user ends the command (SIGINT,
/// SIGTERM, SIGHUP, unless they are ignored). A second signal, at least 100 ms later, ends the process at once,
/// whatever it does. There is one object in a process.
///
/// Thread safety: Wake() and ended() from any thread; the rest on the thread of the command.
class Pause {
 public:
  enum class End { kWoken, kDeadline, kInterrupted };

  Pause();
  Pause(const Pause&) = delete;
  Pause& operator=(const Pause&) = delete;
  ~Pause();

  void Wake() noexcept;
  /// Returns kInterrupted at once if the user has ended the command before. Throws OutputClosed when the reader of
  /// standard output has gone.
  [[nodiscard]] End Until(std::chrono::steady_clock::time_point deadline);
  /// The same, and also kWoken when `descriptor` can be read.
  [[nodiscard]] End UntilReadable(int descriptor, std::chrono::steady_clock::time_point deadline);
  /// Waits until `time`, also if another thread calls Wake(). Returns false if the user has ended the command.
  [[nodiscard]] bool SleepUntil(std::chrono::steady_clock::time_point time);
  [[nodiscard]] End For(std::chrono::nanoseconds time) { return Until(std::chrono::steady_clock::now() + time); }
  /// From now on waits call this once a second, with the time since this call. Empty: they do not.
  void EachSecond(std::function<void(std::chrono::seconds passed)> tell);
  /// The signal that ended the command; 0: none.
  [[nodiscard]] int signal() const noexcept;
  /// From now on, only a third signal ends the process at once.
  void OutlastTheSecond() noexcept;
  [[nodiscard]] bool signaled_again() const noexcept;
  /// A descriptor that can be read once the user has ended the command.
  [[nodiscard]] int ended() const noexcept { return ended_; }
  /// Ends this process by the signal that ended the command, as its caller expects. Returns if there was none.
  void EndBySignal() const;

 private:
  // Calls tell_ if a second has passed since it was called. Returns when it is due again.
  std::chrono::steady_clock::time_point Tell();

  int ended_ = -1;
  int wakes_ = -1;
  std::function<void(std::chrono::seconds)> tell_;
  std::chrono::seconds told_{0};                 // With the next seconds that pass, tell_ is called.
  std::chrono::steady_clock::time_point begin_;  // Of these seconds.
};

}  // namespace hgros::cli
