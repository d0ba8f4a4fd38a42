#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/clock/clock_offset.hpp"
#include "hgros/codec/type_info.hpp"
#include "hgros/internal/codec/packet.hpp"
#include "hgros/transport/demand.hpp"
#include "hgros/transport/inbound_channel.hpp"
#include "hgros/transport/outbound_channel.hpp"
#include "hgros/transport/peer_info.hpp"
#include "hgros/transport/transport_stats.hpp"

namespace hgros {

/// Events of a transport that concern the whole session. Called on the transport's threads; must not block.
class TransportListener {
 public:
  virtual ~TransportListener() = default;
  virtual void OnPeerCame(const PeerInfo& peer) noexcept = 0;
  /// `reason` completes "it is gone: ": it said goodbye, its process has ended, the connection was closed ...
  virtual void OnPeerGone(const PeerInfo& peer, std::string_view reason) noexcept = 0;
  /// Two sides of a channel do not fit. Called on both sides, once per peer and channel. `what` names the channel, both
  /// sessions and both types, without a final full stop.
  virtual void OnTypeMismatch(std::string_view channel, const PeerInfo& peer, std::string_view what) noexcept = 0;
  /// Peers publish or subscribe to other channels than before; see the transport's own interface.
  virtual void OnChannels() noexcept {}
  /// The peer has sent the time of its wall clock. Called now and then while the peer is connected, on both sides of
  /// each pair. Only transports between hosts call it.
  virtual void OnClockExchange(const PeerInfo& /*peer*/, const ClockExchange& /*exchange*/) noexcept {}
};

/// A thread that waits for a message and reads the input itself, so that no other thread has to be woken.
struct Visit {
  std::function<bool()> done;                   ///< Must not block.
  std::chrono::steady_clock::time_point until;  ///< If this is in the past, it reads only what is there.
  std::function<void()> first = [] {};          ///< Runs before that, and also if this thread cannot read.
};

/// One way to move messages between sessions. Every transport passes tests/conformance.
/// Thread-safe. A transport's threads never run user code except in InboundSink::Run() after kRunApart.
class Transport {
 public:
  virtual ~Transport() = default;
  /// Offers `channel` to other sessions. `type` outlives the transport; `source` outlives the returned object.
  [[nodiscard]] virtual std::unique_ptr<OutboundChannel> Advertise(std::string_view channel, const TypeInfo& type,
                                                                   OutboundSource& source) = 0;
  /// Asks all publishers of `channel` for its messages; for messages of every type if `type` is AnyType(). `sink`
  /// outlives the returned object.
  [[nodiscard]] virtual std::unique_ptr<InboundChannel> Subscribe(std::string_view channel, const TypeInfo& type,
                                                                  const Demand& demand, InboundSink& sink) = 0;
  [[nodiscard]] virtual std::vector<PeerInfo> Peers() const = 0;
  [[nodiscard]] virtual TransportStats stats() const = 0;
  /// The channels that connected sessions offer here or ask for.
  [[nodiscard]] virtual std::vector<SessionChannels> KnownChannels() const { return {}; }

  /// Checks again which channels are to be received over this transport: ends the others, and asks publishers for
  /// these.
  virtual void AskAgain() {}
  /// Where other sessions of this host find this one, for announcements; empty: they cannot.
  [[nodiscard]] virtual const std::string& place() const noexcept {
    static const std::string no_place;
    return no_place;
  }
  /// Connects to the session at `place`, and reconnects until RemovePeer(). A session that has connected to this one is
  /// not connected twice.
  virtual void AddPeer(const std::string& /*place*/) {}
  /// Does not connect to `place` any more. A connection that exists stays until either side ends.
  virtual void RemovePeer(const std::string& /*place*/) {}
  /// Why the session at `place` is not reached, as far as it is known here; completes a sentence after ": ". Empty: no
  /// cause was found.
  [[nodiscard]] virtual std::string Obstacle(SessionId /*peer*/, const std::string& /*place*/) const { return {}; }
  /// Receives on the calling thread, which then calls InboundSink::Accept(), and Run() after kRunHere. Returns at once
  /// if another thread receives, or if the transport does not support this.
  virtual void Receive(const Visit& visit) noexcept { visit.first(); }
  /// Receives on the calling thread until the visit ends, and sleeps meanwhile; this thread also calls Run() after
  /// kRunApart. `first` is not called. It may return earlier, as after a signal. False at once if another thread
  /// receives so, or if the transport does not support this.
  [[nodiscard]] virtual bool ReceiveHere(const Visit& /*visit*/) noexcept { return false; }
  /// Lets ReceiveHere() look at `done` once more. Takes no lock.
  virtual void WakeReceiver() noexcept {}
  /// Whether the calling thread reads for Receive() or ReceiveHere() of a transport.
  [[nodiscard]] static bool IsVisitor() noexcept;
  /// For InboundSink::Run(). True if ReceiveHere() called it, whose thread has something else to do soon: then another
  /// thread calls Run() once more, and this one returns.
  [[nodiscard]] static bool LeaveRest() noexcept;

  /// Close() follows soon, so the peers need not be told of each subscription that ends until then.
  virtual void Leave() noexcept {}
  /// Says goodbye to the peers, sends committed messages as far as `linger_ms` allows, and stops receiving. Waits
  /// longer, and at most `at_most_ms`, while messages still arrive at its peers. Later calls do nothing.
  virtual void Close(int linger_ms, int at_most_ms) noexcept = 0;
  void Close(int linger_ms) noexcept { Close(linger_ms, linger_ms); }
};

}  // namespace hgros
