#pragma once

#include <string>
#include <utility>

namespace hgros::viewer {

/// The viewer's messages to users: a notice in the status line, lines on standard error, and the exit code.
class Notices {
 public:
  /// Shows a notice in the status line until the next one.
  void Show(std::string notice) { shown_ = std::move(notice); }
  /// Writes a line to standard error.
  static void Print(const std::string& line);
  void ShowAndPrint(const std::string& notice);
  /// Shows and prints what went wrong. The exit code becomes 1.
  void Fail(const std::string& fault);
  void SetFailed() { exit_code_ = 1; }

  [[nodiscard]] const std::string& shown() const noexcept { return shown_; }
  [[nodiscard]] int exit_code() const noexcept { return exit_code_; }

 private:
  std::string shown_;
  int exit_code_ = 0;
};

}  // namespace hgros::viewer
