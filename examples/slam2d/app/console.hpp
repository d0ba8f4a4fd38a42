#pragma once

#include <chrono>
#include <mutex>
#include <string>
#include <string_view>

#include <hgros/base/log.hpp>

namespace slam2d {

/// Standard error as the user sees it: sentences, and below them one line of progress that is rewritten on a terminal
/// and repeated every few seconds elsewhere.
///
/// Threading: thread-safe.
class Console {
 public:
  /// Quiet: only what goes wrong.
  explicit Console(bool quiet);
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;
  ~Console();

  void Say(std::string_view sentence);
  /// Not the same one twice in a row: several nodes may find one fault.
  void Warn(std::string_view sentence);
  /// Where the library says what goes wrong. To be used no longer than the console.
  [[nodiscard]] hgros::LogSink log();
  void Progress(const std::string& line);
  /// Takes the line of progress away.
  void EndProgress();

  /// How often Progress() is worth calling.
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
