#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <deque>
#include <optional>

namespace hgros::cli {

/// How long to wait before each restart: the first one is immediate, further ones wait 100 ms, 200 ms, and so on. After
/// five within a minute there are no more.
class RestartPauses {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kMost = 5;
  static constexpr std::chrono::seconds kWindow{60};

  /// The pause before the next restart. Empty: it is not started again.
  [[nodiscard]] std::optional<std::chrono::milliseconds> Next(Clock::time_point now) {
    while (!restarts_.empty() && restarts_.front() < now - kWindow) restarts_.pop_front();
    if (restarts_.size() >= kMost) return std::nullopt;
    const std::chrono::milliseconds pause =
        restarts_.empty() ? std::chrono::milliseconds(0) : kFirst * (1 << (restarts_.size() - 1));
    restarts_.push_back(now + pause);
    attempts_ = 0;
    return pause;
  }
  /// The pause before the next attempt to reach its host, which is no restart: 1 s, 2 s, and so on up to a minute.
  [[nodiscard]] std::chrono::milliseconds NextAttempt() {
    return std::min<std::chrono::milliseconds>(kFirstAttempt * (1 << std::min(attempts_++, 6)), kWindow);
  }
  /// The next restart is the first one.
  void Forget() {
    restarts_.clear();
    attempts_ = 0;
  }

 private:
  static constexpr std::chrono::milliseconds kFirst{100};
  static constexpr std::chrono::seconds kFirstAttempt{1};

  std::deque<Clock::time_point> restarts_;
  int attempts_ = 0;
};

}  // namespace hgros::cli
