#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>

#include "hgros/transport/call_gate.hpp"
#include "hgros/transport/transport.hpp"
#include "transport/actions.hpp"
#include "transport/leader_pool.hpp"
#include "transport/repeat_filter.hpp"

namespace hgros {

/// Whether two handshake numbers come from one publishing socket, which counts up from a random number.
[[nodiscard]] bool AreOfOneSocket(std::uint64_t one, std::uint64_t other) noexcept;

/// One subscribed channel, as all subscribe endpoints see it.
/// Thread safety: Deliver() belongs to the leading thread; the rest is thread-safe.
class InboundCore {
 public:
  InboundCore(std::string_view channel, const TypeInfo& message_type, const Demand& demand, InboundSink& sink);

  /// The fault of a message's head: the kind, and a text that completes "channel NAME: ". `compared` is the
  /// fingerprint that was compared with ours when the sender's link was made; 0: none was.
  struct HeadFault {
    PacketFault fault = PacketFault::kNone;
    std::string what;
  };
  [[nodiscard]] HeadFault Check(const PacketHead& head, SessionId from, std::uint64_t compared) const;
  /// Gives a message to the sink; a repeat is counted in `repeats` instead. A returned task must run on another
  /// thread.
  [[nodiscard]] static LeaderPool::Task Deliver(const std::shared_ptr<InboundCore>& core, InboundMessage&& message,
                                                std::atomic<std::uint64_t>& repeats);
  /// Reports a dropped packet to the sink.
  void TellFault(PacketFault fault, std::string_view what);

  /// Claims the channel for an endpoint. A publisher sends us a channel over one endpoint only, the first one that
  /// claims it. `endpoint` identifies that endpoint. `handshake` is the number in the publisher's latest Welcome
  /// there. Endpoints with close numbers lead to one socket of the publisher, which sends everything to both.
  [[nodiscard]] bool Claim(SessionId publisher, const void* endpoint, std::uint64_t handshake);
  /// Whether another endpoint that leads to the same socket has the claim.
  [[nodiscard]] bool IsClaimedBeside(SessionId publisher, const void* endpoint, std::uint64_t handshake) const;
  [[nodiscard]] bool IsClaimed(SessionId publisher) const;
  /// True if `endpoint` had the claim.
  bool Release(SessionId publisher, const void* endpoint);
  /// Reports a publisher's schema to the sink, if the sink accepts any type.
  static void TellOffer(const std::shared_ptr<InboundCore>& core, const PeerInfo& from,
                        const std::shared_ptr<const MessageSchema>& schema, Actions& actions);
  /// That session has come as a publisher (1) or is one no more (-1).
  static void CountPublisher(const std::shared_ptr<InboundCore>& core, SessionId who, int change, Actions& actions,
                             OfferEnd why = OfferEnd::kLost);

  [[nodiscard]] Demand demand() const;
  void SetDemand(const Demand& demand);
  /// After this, no call reaches the sink. Waits for calls inside, except the caller's own.
  void Close() { gate_.Close(); }
  /// Whether Run() is in flight, which may last as long as a callback.
  [[nodiscard]] bool busy() const { return (std::scoped_lock(mutex_), running_ > 0); }

  const std::string name;
  const std::string plain_topic;
  const TypeInfo& type;
  std::atomic<std::size_t> publishers{0};

 private:
  [[nodiscard]] bool StartRun();
  void RunApart();

  InboundSink& sink_;  // Called through `gate_` only.
  CallGate gate_;
  RepeatFilter repeats_;
  mutable std::mutex mutex_;
  Demand demand_;
  struct Claimed {
    const void* endpoint;
    std::uint64_t handshake;
  };
  std::unordered_map<SessionId, Claimed> claims_;
  // Several runs of one sink may be active at once, but not on all threads: above a limit they wait for each other.
  std::size_t running_ = 0;
  std::size_t owed_runs_ = 0;
};

}  // namespace hgros
