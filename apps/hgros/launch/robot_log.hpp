#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string_view>
#include <utility>
#include <vector>

#include "launch/log_lines.hpp"
#include "launch/robot.pb.h"
#include "terminal/console.hpp"

namespace hgros::cli {

/// What a starter shows: the log of its robot. If nothing can be written any more, such as on a full disk, that is said
/// once, and the robot runs on. If nobody reads what is written, such as a pager, lines are left out and counted.
///
/// Threading: one thread.
class RobotLog {
 public:
  struct Look {
    bool json = false;
    bool debug = false;     ///< Also lines of that level.
    std::size_t width = 0;  ///< Of the names.
  };
  RobotLog(Console& console, Look look) : console_(console), look_(look) {}

  /// Called with each new line.
  void Tell(std::function<void(const LogLine& line)> tell) { tell_ = std::move(tell); }
  /// Keeps a line, and shows it.
  void Add(LogLine line);
  /// Shows a line again, below others.
  void Repeat(const LogLine& line);
  /// Shows a table of what runs.
  void ShowStates(const std::vector<RobotReply::Unit>& units);
  /// Shows a line that is not of the log.
  void Write(std::string_view line);
  /// From now on, all writes together wait at most this long for a reader.
  void WaitAtMost(std::chrono::milliseconds time) { wait_until_ = std::chrono::steady_clock::now() + time; }
  /// Says what was left out.
  void End();
  /// Nobody reads it any more.
  void Silence() noexcept { silent_ = true; }

  [[nodiscard]] const LogLines& lines() const noexcept { return lines_; }

 private:
  // Calls `write`, which writes to the console.
  void Guard(const std::function<void()>& write);
  void SayUnread(std::uint64_t lines);

  Console& console_;
  const Look look_;
  LogLines lines_;
  std::function<void(const LogLine&)> tell_;
  bool silent_ = false;
  std::chrono::steady_clock::time_point wait_until_ = std::chrono::steady_clock::time_point::max();
  std::uint64_t unread_ = 0;  // Lines that were left out since one was written.
};

}  // namespace hgros::cli
