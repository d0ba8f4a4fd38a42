#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "transport/inbound_core.hpp"
#include "transport/leader_pool.hpp"
#include "transport/zmq/shared_state.hpp"
#include "transport/zmq/socket.hpp"

namespace hgros::zmq {

/// A received data packet whose topic was already read.
struct InboundPacket {
  Message head;
  Message data;
  SessionId from;        ///< Zero if it is from a plain publisher.
  bool trusted = false;  ///< See InboundMessage.
  std::shared_ptr<const void> credit;
  std::uint64_t fingerprint = 0;  ///< Identifies the type that the publisher named for the link; compared with ours.
  std::shared_ptr<const MessageSchema> schema;  ///< That type, if it is not ours.
};

/// Decodes the packet's head and gives the message to the channel. Called on the leading thread; a returned task must
/// run on another one.
[[nodiscard]] LeaderPool::Task DeliverPacket(const std::shared_ptr<InboundCore>& core, InboundPacket&& packet,
                                             SharedState& shared, const std::string& endpoint);
/// Counts and logs a dropped packet of the channel, and reports it to the channel.
void ReportFault(InboundCore& core, SharedState& shared, const std::string& where, PacketFault fault,
                 std::string_view what);

}  // namespace hgros::zmq
