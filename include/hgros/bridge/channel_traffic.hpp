#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "hgros/base/histogram.hpp"
#include "hgros/base/ids.hpp"
#include "hgros/internal/codec/packet.hpp"
#include "hgros/transport/transport_stats.hpp"

namespace hgros {

/// Messages received from one remote publisher on one channel.
struct PublisherTraffic {
  SessionId publisher;
  std::uint64_t received = 0;
  std::uint64_t lost = 0;      ///< Gaps in its sequence numbers: a side was too slow or cut off for a while.
  std::uint64_t repeated = 0;  ///< Received again; not delivered again.
};

/// Messages of one channel that left or entered this process.
struct ChannelTraffic {
  std::string channel;
  OutboundStats out;                ///< Summed over the transports.
  std::uint64_t encoded = 0;        ///< Messages written for other sessions, once for all of them.
  std::uint64_t encoded_bytes = 0;  ///< The bytes of these.
  std::uint64_t not_encodable = 0;  ///< Messages whose codec refused to write them.
  std::uint64_t loans = 0;          ///< Blocks that Session::Loan returned.
  std::uint64_t heap_loans = 0;     ///< Loans in ordinary memory: no subscriber on this host, or no shared memory left.
  std::size_t publishers = 0;       ///< Remote sessions that publish to us now.
  std::vector<PublisherTraffic> in;
  std::array<std::uint64_t, kPacketFaultCount> faults{};  ///< Dropped packets by PacketFault.
  /// Time from the sender's publish to the delivery here, in ns, by the wall clocks of both hosts. Corrected by the
  /// offset between them, as far as it is known.
  LogHistogram transport;
};

}  // namespace hgros
