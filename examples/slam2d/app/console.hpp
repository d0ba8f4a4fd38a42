#pragma once

#include <chrono>
#include <mutex>
#include <string>
#include <string_view>

#include <hgros/base/log.hpp>

namespace slam2d {

/// The program's output on standard error: sentences, and below them one line of progress that is rewritten on a
/// terminal and repeated every few seconds elsewhere.
///
/// Threading: thread-safe.
class Console {
 public:
  /// Quiet: prints warnings and errors only.
  explicit Console(bool quiet);
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;
  ~Console();

  void Say(std::string_view sentence);
  /// Prints a warning, but not the same one twice in a row: several nodes may report one error.
  void Warn(std::string_view sentence);
  /// The log of the library. Not to be used after the console is destroyed.
  [[nodiscard]] hgros::LogSink log();
  void Progress(const std::string& line);
  /// Removes the line of progress.
  void EndProgress();

  /// The useful interval between calls of Progress().
  [[nodiscard]] std::chrono::milliseconds period() const;

 private:
  void Write(std::string_view sentence);
  void Clear();

  const bool quiet_;
  const bool terminal_;
  std::mutex mutex_;
  bool line_shown_ = false;
  std::string last_line_;
  std::string last_warning_;
};

}  // namespace slam2d
