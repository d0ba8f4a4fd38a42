#pragma once

#include <cstdint>

#include "hgros/base/ids.hpp"

namespace hgros {

/// Metadata of a message, passed next to it.
struct MessageInfo {
  /// The sender. For local messages the sequence counts the channel's messages, for remote ones the sender's.
  MessageId id;
  std::int64_t publish_monotonic_ns = 0;  ///< CLOCK_MONOTONIC when published, or when received from another host.
  std::int64_t publish_time_ns = 0;       ///< Remote messages: the sender's wall clock, ns since 1970; 0: unknown.
  bool remote = false;                    ///< Received over a transport.
};

}  // namespace hgros
