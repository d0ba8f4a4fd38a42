#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/bytes.hpp"
#include "hgros/base/ids.hpp"
#include "hgros/base/publish_status.hpp"
#include "hgros/clock/clock_offset.hpp"
#include "hgros/codec/block.hpp"
#include "hgros/codec/packet.hpp"
#include "hgros/codec/raw_message.hpp"
#include "hgros/codec/type_info.hpp"

namespace hgros {

/// What one subscribing session asks of a publishing one, for one channel.
struct Demand {
  bool lossless = false;               ///< Nothing may be dropped; the publisher is told "full" instead.
  std::uint32_t queue_depth = 16;      ///< Keep-last: how many messages the sender keeps for us while we are slow.
  std::uint32_t credit_messages = 64;  ///< In flight at most, from one publisher.
  std::uint64_t credit_bytes = 64ULL * 1024 * 1024;  ///< Likewise; one message is let through whatever its size.

  bool operator==(const Demand&) const = default;
};

/// One received message, checked as a packet but not decoded.
struct InboundMessage {
  PacketHead head;
  Payload data;
  SessionId from;  ///< None if the sender is not a HyperGraph ROS session.
  /// What the sender said when the link was made, if it is not the type that was subscribed to.
  std::shared_ptr<const MessageSchema> schema;
  /// While any copy lives the message counts as in flight, and the sender's credit stays used. A sender that knows no
  /// credit is cut short instead: what it sends while too much is in flight is dropped (PacketFault::kOverrun).
  std::shared_ptr<const void> credit;
};

/// A session as seen over one carrier.
struct PeerInfo {
  SessionId id;
  std::string process;  ///< Its program's name.
  std::string host;     ///< Its host's name; for people, never compared.
  std::int64_t pid = 0;
  std::string endpoint;  ///< Where we connected to, or empty if it connected to us.
  std::string carrier;   ///< What carries its messages: "shared memory" or "ZeroMQ"; told by the session.
  std::string why;       ///< Why that carrier, in a few words: "same host"; likewise.
};

/// What happens to an accepted message next.
enum class Accepted {
  kNothing,   ///< It is taken care of.
  kRunHere,   ///< Call Run() now, on this thread; it is quick and runs no user code.
  kRunApart,  ///< Call Run() on a thread that owns no socket, credits or heartbeats: it may run user code.
};

/// Where a carrier puts what it receives on one channel. Implemented by the session.
///
/// Contract:
///  1. The carrier calls Accept() for the messages of one publisher in their order, one call at a time per sink.
///  2. If Accept() does not return kNothing the carrier calls Run() exactly once for it, soon.
///  3. After InboundChannel's destructor has returned neither is called again.
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
  /// That session will send, or sends, messages of this type: told for each one if the channel is subscribed to with
  /// AnyType(). Perhaps after the first of them.
  virtual void OnOffer(const PeerInfo& /*from*/, const std::shared_ptr<const MessageSchema>& /*schema*/) noexcept {}
};

/// One message of this session on its way out.
struct OutboundMessage {
  PacketHead head;
  Payload data;
};

/// What a carrier asks of, and tells, the publishing side of one channel. Implemented by the session.
class OutboundSource {
 public:
  virtual ~OutboundSource() = default;
  /// The latched messages, oldest first, for a subscriber that has just come: it counts in subscriber_count() before
  /// this is called, and what is committed from then on reaches it after them. On a carrier's thread: no user code.
  virtual std::vector<OutboundMessage> Latched(SessionId subscriber) noexcept = 0;
  /// A lossless subscriber was lost that may live on, and has not confirmed `unfinished` (oldest first). True: it gets
  /// them when it comes back, over whatever carrier, from Latched(). False: it misses them. Under a lock that Commit()
  /// takes as well, so that nothing falls in between; the carrier must not be called.
  virtual bool OnCut(SessionId /*subscriber*/, const Demand& /*demand*/,
                     std::vector<OutboundMessage>&& /*unfinished*/) noexcept {
    return false;
  }
  /// A lossless subscriber that had no credit has some again, or has gone.
  virtual void OnRoom() noexcept = 0;
  /// The number of remote subscribers has changed.
  virtual void OnSubscribers(std::size_t count) noexcept = 0;
};

/// The publishing end of one channel on one carrier. Destroying it withdraws the channel.
///
/// Contract:
///  1. Reserve() takes one message of credit from every lossless subscriber, or from none (kFull).
///  2. A kOk from Reserve() is followed by exactly one Commit() or Cancel().
///  3. Commit() hands the message to every subscriber: lossless ones have credit for it; keep-last ones without
///     credit find it in a ring of the depth they asked for, from which the oldest is dropped and counted; plain
///     ones get it if they keep up. It never blocks. Messages committed one after the other arrive in that order.
///     Those of one publisher are committed in the order of their sequence numbers: what comes behind a later one is
///     taken for a repeat.
///  4. A subscriber that dies gives its credit back (OnRoom); what it had not confirmed is counted as missed, unless
///     the source keeps it (OnCut).
///  5. A lossless subscriber that was only cut off for a while gets what it missed, in order, exactly once.
///  6. What is let go of in Reserve() and Commit() ends under no lock of the carrier's, and with the
///     caller's EndsLater if it has one.
/// Thread-safe.
class OutboundChannel {
 public:
  struct Stats {
    std::size_t subscribers = 0;
    std::uint64_t sent = 0;  ///< Messages handed to the network, one per subscriber.
    /// Dropped from the rings of slow keep-last or plain subscribers, or larger than a keep-last subscriber takes.
    std::uint64_t dropped = 0;
    /// Not confirmed by lossless subscribers that died, or larger than a lossless subscriber takes.
    std::uint64_t missed = 0;
    std::uint64_t queued_bytes = 0;  ///< Waiting in rings now.
    /// Messages whose encoded bytes were copied once more: into memory that can be shared, because they did not lie
    /// there; or, of a type that can be sent where it lies (Bulk), because this one could not.
    std::uint64_t copied = 0;
  };

  virtual ~OutboundChannel() = default;
  /// Remote subscribers, plain ones counted as one. Cheap: one relaxed load. 0: nothing needs to be encoded.
  [[nodiscard]] virtual std::size_t subscriber_count() const noexcept = 0;
  /// The sessions among them, in the order in which they came.
  [[nodiscard]] virtual std::vector<SessionId> Subscribers() const { return {}; }
  virtual PublishStatus Reserve() noexcept = 0;
  virtual void Commit(const PacketHead& head, const Payload& data) noexcept = 0;
  virtual void Cancel() noexcept = 0;
  /// Memory of this carrier's, in which a message that is written is committed without a copy. Nothing if the carrier
  /// has no such memory, or none left.
  [[nodiscard]] virtual std::optional<Block> Loan(std::size_t /*size_bytes*/) { return std::nullopt; }
  [[nodiscard]] virtual Stats stats() const = 0;
};

/// The subscribing end of one channel on one carrier. Destroying it ends the subscription; the destructor waits for
/// Accept() and Run() in flight unless it is called from within one.
class InboundChannel {
 public:
  virtual ~InboundChannel() = default;
  /// Publishing sessions connected and welcomed.
  [[nodiscard]] virtual std::size_t publisher_count() const noexcept = 0;
  /// Whether that session is asked for the channel here, and has not said that it is not to be had.
  [[nodiscard]] virtual bool Asks(SessionId /*publisher*/) const { return false; }
  /// Changes what is asked of the publishers, from the next message on.
  virtual void SetDemand(const Demand& demand) = 0;
};

/// What a session does with one channel.
struct ChannelUse {
  std::string channel;
  std::string type_name = {};  ///< Empty: it takes any, or does not say.
  Encoding encoding = Encoding::kNone;
  std::uint64_t fingerprint = 0;  ///< 0: unknown.
  bool publishes = false;
  bool subscribes = false;
  bool lossless = false;  ///< As a subscriber.
};

/// A session and what is known of its channels.
struct SessionChannels {
  PeerInfo session;
  std::vector<ChannelUse> channels;
};

/// What a carrier tells the session as a whole. Called on carrier threads; must not block.
class TransportListener {
 public:
  virtual ~TransportListener() = default;
  virtual void OnPeerCame(const PeerInfo& peer) noexcept = 0;
  /// `reason` completes "it is gone: ": it said goodbye, its process has ended, the connection was closed ...
  virtual void OnPeerGone(const PeerInfo& peer, std::string_view reason) noexcept = 0;
  /// Two sides of a channel do not fit. Said on both sides, once per peer and channel. `what` names the channel and
  /// both types, without a final full stop.
  virtual void OnTypeMismatch(std::string_view channel, const PeerInfo& peer, std::string_view what) noexcept = 0;
  /// What peers do with channels has changed; the carrier tells what.
  virtual void OnChannels() noexcept {}
  /// The peer has told the time of its wall clock, now and then while it is reached; each pair of peers hears so on
  /// both sides. Of carriers that leave the host only.
  virtual void OnClockExchange(const PeerInfo& /*peer*/, const ClockExchange& /*exchange*/) noexcept {}
};

/// A thread that waits for what comes in and reads it itself, so that no other is woken for it.
struct Visit {
  std::function<bool()> done;                   ///< Must not block.
  std::chrono::steady_clock::time_point until;  ///< If it lies behind, it reads what is there.
  std::function<void()> first = [] {};          ///< Runs before that, and also if nothing can be read so.
};

/// Packets that were dropped, those of unknown channels included.
struct TransportStats {
  std::array<std::uint64_t, kPacketFaultCount> faults{};
  std::uint64_t repeats = 0;  ///< Came again and were not delivered again.
};

/// One way to move messages between sessions. Every carrier passes tests/conformance.
/// Thread-safe. The carrier's threads never run user code except in InboundSink::Run() after kRunApart.
class Transport {
 public:
  virtual ~Transport() = default;
  /// Offers `channel` to other sessions. `type` outlives the transport; `source` outlives the returned object.
  [[nodiscard]] virtual std::unique_ptr<OutboundChannel> Advertise(std::string_view channel, const TypeInfo& type,
                                                                   OutboundSource& source) = 0;
  /// Asks all publishers of `channel` for its messages, whatever they are if `type` is AnyType(). `sink` outlives the
  /// returned object.
  [[nodiscard]] virtual std::unique_ptr<InboundChannel> Subscribe(std::string_view channel, const TypeInfo& type,
                                                                  const Demand& demand, InboundSink& sink) = 0;
  [[nodiscard]] virtual std::vector<PeerInfo> Peers() const = 0;
  [[nodiscard]] virtual TransportStats stats() const = 0;
  /// Says goodbye, sends what was committed as far as `linger_ms` allows, stops receiving. Later calls do nothing.
  virtual void Close(int linger_ms) noexcept = 0;
};

}  // namespace hgros
