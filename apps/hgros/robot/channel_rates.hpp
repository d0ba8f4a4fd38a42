#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "robot/overview.hpp"

namespace hgros::cli {

/// What the publishers of a channel do together.
struct ChannelRate {
  std::uint64_t publishers = 0;  ///< Whose counters are known.
  std::uint64_t published = 0;   ///< Since their sessions began.
  double rate_hz = 0;
  std::optional<double> mean_bytes;  ///< None: no message was written for other sessions yet.
};

/// Messages per second of a publisher that has published `messages` in `seconds`. Regular messages are more than
/// (messages - 1) / seconds and less than (messages + 1) / seconds: within that it is `own_hz`, the publisher's own
/// rate, which is exact for slow channels, too. `seconds` is 0 at first.
[[nodiscard]] double PublishedRate(double own_hz, std::uint64_t messages, double seconds);

/// Rates from the counters that publishers keep, without a message received.
///
/// Threading: one thread.
class ChannelRates {
 public:
  /// Call it about once a second with the newest counters. A publisher that has sent none for four calls is left out.
  [[nodiscard]] ChannelRate Next(const AllCounters& counters, const KnownChannel& channel);

 private:
  struct Known {
    std::int64_t steady_ns = 0;
    std::uint64_t published = 0;
    std::uint64_t encoded = 0;
    std::uint64_t encoded_bytes = 0;
    double rate_hz = 0;
    std::uint64_t new_encoded = 0;  // In the last interval, or if there was none then, since the session began.
    std::uint64_t new_bytes = 0;
    int unchanged = 0;  // Calls without newer counters.
  };
  static void Take(Known& known, const Snapshot& snapshot, const Snapshot::Channel& channel);

  std::map<std::pair<SessionId, std::string>, Known> known_;
};

}  // namespace hgros::cli
