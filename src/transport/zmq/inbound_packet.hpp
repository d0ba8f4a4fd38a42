#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "transport/inbound_core.hpp"
#include "transport/leader_pool.hpp"
#include "transport/zmq/carrier.hpp"
#include "transport/zmq/socket.hpp"

namespace hgros::zmq {

/// A data packet as it came, its topic already read.
struct InboundPacket {
  Message head;
  Message data;
  SessionId from;  ///< None from a plain publisher.
  std::shared_ptr<const void> credit;
  std::uint64_t fingerprint = 0;  ///< Of the type that the session named for the link, and that was compared with ours.
  std::shared_ptr<const MessageSchema> schema;  ///< Likewise, if it is not ours.
};

/// Reads the packet and gives it to the channel. What is returned runs apart. On the leading thread.
[[nodiscard]] LeaderPool::Task Deliver(const std::shared_ptr<InboundCore>& core, InboundPacket&& packet,
                                       Carrier& carrier, const std::string& endpoint);
/// A packet for the channel was dropped: counted, logged and told.
void Fault(InboundCore& core, Carrier& carrier, const std::string& where, PacketFault fault, std::string_view what);

}  // namespace hgros::zmq
