#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>
#include <string_view>

#include "hgros/base/log.hpp"
#include "terminal/console.hpp"

namespace hgros::cli {

/// A line of a robot's log.
struct LogLine {
  std::int64_t time_ns = 0;  ///< Of the system's clock.
  std::string process;       ///< Or program.
  std::string component;     ///< Empty: of the process itself, or printed.
  LogLevel level = LogLevel::kInfo;
  std::string text;
};

/// The newest lines of a robot's log.
class LogLines {
 public:
  /// `time_ns` of a line without one is set.
  void Add(LogLine line);
  [[nodiscard]] const std::deque<LogLine>& all() const noexcept { return lines_; }

 private:
  std::deque<LogLine> lines_;
  std::size_t bytes_ = 0;
};

/// "12:13:14.123 mapper  The map is empty.", with the level if it is not info. `width`: of the names.
[[nodiscard]] std::string LineText(const Console& console, const LogLine& line, std::size_t width);
[[nodiscard]] std::string LineJson(const LogLine& line);

}  // namespace hgros::cli
