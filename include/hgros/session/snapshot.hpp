#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "hgros/base/histogram.hpp"
#include "hgros/base/ids.hpp"
#include "hgros/codec/packet.hpp"
#include "hgros/graph/snapshot.hpp"
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
  OutboundChannel::Stats out;       ///< Summed over the carriers.
  std::uint64_t not_encodable = 0;  ///< Messages whose codec refused to write them.
  std::uint64_t loans = 0;          ///< Blocks that Session::Loan gave.
  std::uint64_t heap_loans = 0;     ///< Of these, in ordinary memory: nobody received there, or none was left.
  std::size_t publishers = 0;       ///< Remote sessions that publish to us now.
  std::vector<PublisherTraffic> in;
  std::array<std::uint64_t, kPacketFaultCount> faults{};  ///< Dropped packets by PacketFault.
  /// From the sender's publish to our delivery by the wall clocks, ns; corrected by what is known of their offset.
  LogHistogram transport;
};

/// A service that the session offers. Its node in the graph, under the same name, counts what was handled.
struct ServiceSnapshot {
  std::string name;
  std::uint64_t unhandled_requests =
      0;  ///< Callers that waited no more when their turn came: out of time, cancelled, gone.
  std::uint64_t dropped_replies = 0;  ///< Callers that were gone, or took none while 65536 waited for them.
};

/// Everything a session counts, at one moment.
struct SessionSnapshot {
  SessionId id;
  std::string name;
  GraphSnapshot graph;
  std::vector<ChannelTraffic> traffic;    ///< Sorted by channel; only channels that reach outside.
  std::vector<ServiceSnapshot> services;  ///< Sorted by name.
  std::vector<PeerInfo> peers;
  TransportStats transport;
};

}  // namespace hgros
