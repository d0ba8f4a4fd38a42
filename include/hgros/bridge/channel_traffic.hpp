#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "hgros/base/histogram.hpp"
#include "hgros/base/ids.hpp"
#include "hgros/internal/codec/packet.hpp"
#include "hgros/transport/transport.hpp"

namespace hgros {

/// What came from one remote publisher on one channel.
struct PublisherTraffic {
  SessionId publisher;
  std::uint64_t received = 0;
  std::uint64_t lost = 0;      ///< Gaps in its sequence: somebody was too slow, or cut off for a while.
  std::uint64_t repeated = 0;  ///< Came again and were not delivered again.
};

/// What crossed the border of the process on one channel.
struct ChannelTraffic {
  std::string channel;
  OutboundChannel::Stats out;       ///< Summed over the transports.
  std::uint64_t not_encodable = 0;  ///< Messages whose codec refused to write them.
  std::uint64_t loans = 0;          ///< Blocks that Session::Loan gave.
  std::uint64_t heap_loans = 0;     ///< Of these, in ordinary memory: nobody received there, or none was left.
  std::size_t publishers = 0;       ///< Remote sessions that publish to us now.
  std::vector<PublisherTraffic> in;
  std::array<std::uint64_t, kPacketFaultCount> faults{};  ///< Dropped packets by PacketFault.
  /// From the sender's publish to our delivery by the wall clocks, ns; corrected by what is known of their offset.
  LogHistogram transport;
};

}  // namespace hgros
