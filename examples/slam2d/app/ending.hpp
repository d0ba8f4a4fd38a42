#pragma once

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>

namespace slam2d {

/// Exit codes. After a signal: 128 + its number, as shells do (130 for Ctrl-C, 143 for SIGTERM).
enum ExitCode : int {
  kSuccess = 0,
  kFailure = 1,   ///< Something went wrong while running.
  kBadInput = 2,  ///< The command line, the configuration or the log cannot be used.
};

/// How this process ends. The first decision wins. Whatever waits for another part of the graph stops with token().
///
/// Threading: thread-safe.
class Ending {
 public:
  void Succeed() { Decide(kSuccess, {}); }
  /// `sentence` tells the user what is wrong.
  void Fail(std::string sentence, int exit_code = kFailure) { Decide(exit_code, std::move(sentence)); }
  void Interrupt(int signal) { Decide(128 + signal, "Interrupted."); }
  /// Fails at `when`, unless the end is decided before.
  void FailAt(std::chrono::steady_clock::time_point when, std::string sentence);

  /// Runs `body`. An exception ends the program with the sentence "`who`: ...".
  template <class Body>
  void Guard(std::string_view who, Body&& body) noexcept {
    try {
      std::forward<Body>(body)();
    } catch (const std::exception& error) {
      Fail(std::string(who) + ": " + error.what());
    }
  }

  /// Stop is requested as soon as the end is decided.
  [[nodiscard]] std::stop_token token() const { return stop_.get_token(); }
  /// Waits until the end is decided; false if `deadline` came first.
  bool WaitUntil(std::chrono::steady_clock::time_point deadline);

  [[nodiscard]] int exit_code() const;
  [[nodiscard]] std::string sentence() const;

 private:
  void Decide(int exit_code, std::string sentence);

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<int> exit_code_;
  std::string sentence_;
  std::optional<std::chrono::steady_clock::time_point> fail_at_;
  std::string fail_sentence_;
  std::stop_source stop_;
};

}  // namespace slam2d
