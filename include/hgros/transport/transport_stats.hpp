#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "hgros/internal/codec/packet.hpp"

namespace hgros {

/// Messages of one channel that left this process.
struct OutboundStats {
  std::size_t subscribers = 0;
  std::uint64_t sent = 0;  ///< Messages handed to the network, one per subscriber.
  /// Dropped from the rings of slow keep-last or plain subscribers, or larger than a keep-last subscriber takes.
  std::uint64_t dropped = 0;
  /// Messages that lossless subscribers did not get, one per subscriber: not confirmed when it was lost, published
  /// until it was back, larger than it takes, or without memory to send them.
  std::uint64_t missed = 0;
  std::uint64_t queued_bytes = 0;  ///< Waiting in rings now.
  /// Messages whose encoded bytes were copied once more: into memory that can be shared, because they were not in
  /// it; or because a message of a type that can be sent in place (Bulk) could not.
  std::uint64_t copied = 0;
};

/// Packets that were dropped, including those of unknown channels.
struct TransportStats {
  std::array<std::uint64_t, kPacketFaultCount> faults{};
  std::uint64_t repeats = 0;  ///< Received again; not delivered again.
};

}  // namespace hgros
