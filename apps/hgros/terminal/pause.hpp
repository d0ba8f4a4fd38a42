#pragma once

#include <chrono>
namespace hgros::cli {

/// Where a command waits: until another thread wakes it, a deadline comes, or the user ends the command (SIGINT,
/// SIGTERM, SIGHUP, unless they are ignored). A second signal ends the process at once, whatever it does. There is one
/// object in a process.
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
  /// The signal that ended the command; 0: none.
  [[nodiscard]] int signal() const noexcept;
  /// A descriptor that can be read once the user has ended the command.
  [[nodiscard]] int ended() const noexcept { return ended_; }
  /// Ends this process by the signal that ended the command, as its caller expects. Returns if there was none.
  void EndBySignal() const;

 private:
  int ended_ = -1;
  int wakes_ = -1;
};

}  // namespace hgros::cli
