#pragma once

#include <cstdint>

namespace hgros {

/// What one subscribing session asks of a publishing one, for one channel.
struct Demand {
  bool lossless = false;               ///< Nothing may be dropped; the publisher is told "full" instead.
  std::uint32_t queue_depth = 16;      ///< Keep-last: how many messages the sender keeps for us while we are slow.
  std::uint32_t credit_messages = 64;  ///< The most messages in flight from one publisher.
  /// The most bytes in flight from one publisher. One message is let through whatever its size.
  std::uint64_t credit_bytes = 64ULL * 1024 * 1024;

  bool operator==(const Demand&) const = default;
};

}  // namespace hgros
