#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "arguments/arguments.hpp"
#include "terminal/console.hpp"

namespace hgros::cli {

/// At most 30 years.
[[nodiscard]] std::chrono::nanoseconds DurationOf(double seconds);

/// What all commands that meet a robot have in common.
struct RobotOptions {
  std::string domain;
  std::vector<std::string> config;
  std::vector<std::string> connect;
  std::optional<double> timeout_s;
  std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();  ///< From here --timeout counts.
  OutputStyle style;
  bool sends = false;  ///< The command also sends to other hosts: through the publisher endpoints of --config.

  void Declare(Arguments& arguments);
  /// How much is left of --timeout, at least 0; `otherwise` if there is no --timeout.
  [[nodiscard]] std::chrono::nanoseconds Timeout(std::chrono::nanoseconds otherwise) const;
  /// For a wait in vain: throws TimedOut if there is a --timeout, otherwise Error.
  [[noreturn]] void GiveUp(const std::string& what) const;
  /// A sentence after a space for a command whose messages arrive nowhere; empty without --connect.
  [[nodiscard]] std::string SendingHint() const;
};

}  // namespace hgros::cli
