#pragma once

#include <sys/types.h>
#include <termios.h>

#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "hgros/screen/screen_text.hpp"
#include "support/await.hpp"

namespace hgros::cli {

/// The command hgros in a terminal of its own: a shell that runs it as a job, as users do. Killed when this object
/// ends.
class TerminalRun {
 public:
  TerminalRun(const std::vector<std::string>& arguments, const std::map<std::string, std::string>& environment,
              int columns = 80, int lines = 24);
  TerminalRun(const TerminalRun&) = delete;
  TerminalRun& operator=(const TerminalRun&) = delete;
  ~TerminalRun();

  void Type(const std::string& keys) const;
  void Resize(int columns, int lines);
  /// Sends a signal to the command, which must have begun.
  void Signal(int number) const;
  /// Waits until a line of the screen contains `text`.
  [[nodiscard]] bool Shows(const std::string& text) const;
  [[nodiscard]] bool ShowsNot(const std::string& text) const;
  /// Waits until the command has ended. Its exit status, 128 and the signal, or -1.
  [[nodiscard]] int Wait() const;
  [[nodiscard]] ScreenText screen() const;
  /// What was written to the terminal.
  [[nodiscard]] std::string written() const;
  /// Whether the terminal is as it was before the command began: modes, screen, cursor, colors.
  [[nodiscard]] bool Restored() const;

 private:
  void Read();
  [[nodiscard]] pid_t CommandPid() const;

  int master_ = -1;
  int end_[2] = {-1, -1};  // The reader ends when it can be read.
  pid_t shell_ = -1;
  termios before_{};
  mutable std::mutex mutex_;  // Guards the next two.
  ScreenText screen_;
  std::string written_;
  std::thread reader_;
};

}  // namespace hgros::cli
