#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hgros/hgros.hpp"
#include "robot/measurements.hpp"

namespace hgros::cli {

class Robot;

/// What arrived on a channel, since the last report and since the beginning.
struct Arrived {
  std::uint64_t messages = 0;  ///< Since the last report.
  std::uint64_t bytes = 0;     ///< Since the last report.
  double seconds = 0;          ///< Since the last report.
  Measurements intervals_ns;   ///< Between two messages of a channel.
  Measurements sizes_bytes;
  Measurements delays_ns;  ///< From publish to arrival here; the clocks of other hosts are compared.
};

/// Receives a channel and measures. Latched messages from before it began do not count.
class Arrivals {
 public:
  /// Throws Error if the channel cannot be subscribed to.
  Arrivals(Robot& robot, const std::string& channel);

  /// Begins a new interval.
  [[nodiscard]] Arrived Report();
  [[nodiscard]] const std::string& channel() const noexcept { return channel_; }

 private:
  struct State;

  const std::string channel_;
  std::shared_ptr<State> state_;
  Subscription subscription_;  // Ends first.
};

}  // namespace hgros::cli
