#pragma once

#include <cstdint>

#include "hgros/base/cause.hpp"
#include "hgros/base/ids.hpp"

namespace hgros {

/// Metadata of a message, passed next to it.
struct MessageInfo {
  /// The sender. For local messages the sequence counts the channel's messages, for remote ones the sender's.
  MessageId id;
  std::int64_t publish_monotonic_ns = 0;  ///< CLOCK_MONOTONIC when published, or when received from another host.
  std::int64_t publish_time_ns = 0;       ///< Remote messages: the sender's wall clock, ns since 1970; 0: unknown.
  /// Identifies the message in all processes; for Cause::message. Almost surely unique.
  std::uint64_t key = 0;
  /// Counts the messages of the channel in the publishing process, also those that it does not send: the same for all
  /// receivers. 0: the sender does not count.
  std::uint64_t number = 0;
  Cause cause;          ///< What led to the message. `began_ns` is at most one day before the message came.
  bool remote = false;  ///< Received over a transport.
};

}  // namespace hgros
