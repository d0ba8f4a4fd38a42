#pragma once

#include <cstdint>

#include "hgros/base/ids.hpp"

namespace hgros {

/// What travels beside a message, never in it.
struct MessageInfo {
  /// Who sent it. Inside the process the sequence counts the channel's messages; from outside it is the sender's.
  MessageId id;
  std::int64_t publish_monotonic_ns = 0;  ///< CLOCK_MONOTONIC when published, or when received from another host.
  std::int64_t publish_time_ns = 0;       ///< Remote messages: the sender's wall clock, ns since 1970; 0: unknown.
  bool remote = false;                    ///< Came in over a carrier.
};

}  // namespace hgros
