#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>

#include "hgros/base/bytes.hpp"
#include "hgros/base/ids.hpp"
#include "hgros/codec/raw_message.hpp"
#include "hgros/internal/codec/packet.hpp"
#include "hgros/transport/demand.hpp"
#include "hgros/transport/peer_info.hpp"

namespace hgros {

/// One received message, checked as a packet but not decoded.
struct InboundMessage {
  PacketHead head;
  Payload data;
  SessionId from;  ///< None if the sender is not a HyperGraph ROS session.
  /// The sender is a session of the same user on this host, as its kernel says, or has a CURVE key that may subscribe
  /// here, too. So it may steer this session.
  bool trusted = false;
  /// The sender's type, as announced when the link was made, if it is not the type that was subscribed to.
  std::shared_ptr<const MessageSchema> schema;
  /// While any copy of this lives, the message counts as in flight and uses the sender's credit. Messages of a sender
  /// without credit are dropped while too much is in flight (PacketFault::kOverrun).
  std::shared_ptr<const void> credit;
};

/// The next step for an accepted message.
enum class Accepted {
  kNothing,   ///< Nothing to do.
  kRunHere,   ///< Call Run() now, on this thread; it is quick and runs no user code.
  kRunApart,  ///< Call Run() on a thread that owns no socket, credits or heartbeats: it may run user code.
};

enum class OfferEnd : std::uint8_t {
  kWithdrawn,  ///< The publisher has ended the offer; what it publishes before another one is not for this session.
  kLost,       ///< The connection or the subscription has ended.
};

/// Receives a transport's messages of one channel. Implemented by the session.
///
/// Contract:
///  1. The transport calls Accept() for the messages of one publisher in their order, one call at a time per sink.
///  2. If Accept() does not return kNothing, the transport calls Run() exactly once for it, soon.
///  3. After InboundChannel's destructor has returned, neither is called again.
class InboundSink {
 public:
  virtual ~InboundSink() = default;
  /// Never blocks, never runs user code.
  virtual Accepted Accept(InboundMessage&& message) noexcept = 0;
  virtual void Run() noexcept = 0;
  /// A packet for this channel was dropped before it could be accepted. `what` is a sentence for the log.
  virtual void OnFault(PacketFault fault, std::string_view what) noexcept = 0;
  /// The number of publishing sessions connected to this channel has changed.
  virtual void OnPublishers(std::size_t count) noexcept = 0;
  /// That session sends messages of this type, or will. Called for each publisher if the channel is subscribed to with
  /// AnyType(); perhaps after the first message.
  virtual void OnOffer(const PeerInfo& /*from*/, const std::shared_ptr<const MessageSchema>& /*schema*/) noexcept {}
  /// That session sends no more of them.
  virtual void OnOfferEnded(SessionId /*from*/, OfferEnd /*why*/) noexcept {}
};

/// The subscribing end of one channel on one transport. Destroying it ends the subscription; the destructor waits for
/// Accept() and Run() in flight unless it is called from within one. Run() may last as long as a callback of the user.
class InboundChannel {
 public:
  virtual ~InboundChannel() = default;
  /// The number of publishing sessions that have a link for this channel.
  [[nodiscard]] virtual std::size_t publisher_count() const noexcept = 0;
  /// Whether that session was asked for the channel and has not answered that it does not offer it.
  [[nodiscard]] virtual bool Asks(SessionId /*publisher*/) const { return false; }
  /// Changes the demand on the publishers, from the next message on.
  virtual void SetDemand(const Demand& demand) = 0;
  /// Whether Run() is in flight.
  [[nodiscard]] virtual bool busy() const { return false; }
  /// Ends the subscription without waiting: the publishers get their credit back. Only the destructor may follow.
  virtual void End() {}
};

}  // namespace hgros
