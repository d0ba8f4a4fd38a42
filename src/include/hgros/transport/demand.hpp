#pragma once

#include <cstdint>

namespace hgros {

/// The demand of a subscribing session on a publishing session, for one channel.
struct Demand {
  bool lossless = false;               ///< Nothing may be dropped; publishing returns kFull instead.
  std::uint32_t queue_depth = 16;      ///< Keep-last: number of messages that the sender keeps for us.
  std::uint32_t credit_messages = 64;  ///< Maximum number of messages in flight from one publisher.
  /// Maximum number of bytes in flight from one publisher. A single message may pass at any size.
  std::uint64_t credit_bytes = 64ULL * 1024 * 1024;

  bool operator==(const Demand&) const = default;
};

}  // namespace hgros
