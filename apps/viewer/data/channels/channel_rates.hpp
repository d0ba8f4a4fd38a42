#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>

#include "hgros/graph/message_info.hpp"

namespace hgros::viewer {

/// Rate, bandwidth, latency and gaps of one channel over the last few seconds.
///
/// Thread safety: none. Times are CLOCK_MONOTONIC and wall clock in ns, as a caller reads them.
class ChannelRate {
 public:
  static constexpr std::chrono::nanoseconds kWindow = std::chrono::seconds(5);

  void Add(const MessageInfo& info, std::size_t bytes, std::int64_t monotonic_ns, std::int64_t wall_ns);

  struct Figures {
    double messages_per_second = 0;  ///< 0: fewer than two in the window.
    double bytes_per_second = 0;
    std::optional<std::chrono::nanoseconds> latency;  ///< Mean from publishing to arrival; the two clocks may differ.
    std::optional<std::chrono::nanoseconds> jitter;   ///< Standard deviation of the time between messages.
    std::uint64_t messages = 0;                       ///< Since the start.
    std::uint64_t bytes = 0;                          ///< Since the start.
    std::uint64_t missed = 0;                         ///< Gaps in the senders' sequence numbers, since the start.
    std::optional<std::chrono::nanoseconds> silence;  ///< Since the last message.
  };
  [[nodiscard]] Figures At(std::int64_t monotonic_ns) const;

 private:
  struct Arrival {
    std::int64_t at_ns;
    std::size_t bytes;
    std::optional<std::int64_t> latency_ns;
  };
  struct Sender {
    std::uint64_t incarnation = 0;
    std::uint64_t sequence = 0;
  };
  static constexpr std::size_t kMaxArrivals = 10'000;
  static constexpr std::size_t kMaxSenders = 256;

  std::deque<Arrival> arrivals_;
  std::map<std::uint64_t, Sender> senders_;
  std::uint64_t messages_ = 0, bytes_ = 0, missed_ = 0;
};

}  // namespace hgros::viewer
