#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>

#include "hgros/transport/transport.hpp"
#include "transport/call_gate.hpp"
#include "transport/leader_pool.hpp"
#include "transport/repeat_filter.hpp"
#include "transport/zmq/carrier.hpp"

namespace hgros::zmq {

/// A data packet as it came, its topic already read.
struct InboundPacket {
  Message head;
  Message data;
  SessionId from;  // None from a plain publisher.
  std::shared_ptr<const void> credit;
  std::uint64_t fingerprint = 0;  // Of the type that the session named for the link, and that was compared with ours.
};

/// One subscribed channel, as all subscribe endpoints see it.
/// Thread safety: Deliver() is the leading thread's; the rest anywhere.
class InboundCore {
 public:
  InboundCore(std::string_view channel, const TypeInfo& message_type, const Demand& demand, InboundSink& sink);

  /// Checks a packet and gives it to the sink. What is returned runs apart.
  [[nodiscard]] static LeaderPool::Task Deliver(const std::shared_ptr<InboundCore>& core, InboundPacket&& packet,
                                                Carrier& carrier, const std::string& endpoint);
  /// A packet was dropped: counted, logged and told.
  void Fault(Carrier& carrier, const std::string& where, PacketFault fault, std::string_view what);

  /// A publisher sends us this channel over one endpoint only: the first that claims it.
  [[nodiscard]] bool Claim(SessionId publisher, const void* endpoint);
  /// True if `endpoint` had the claim.
  bool Release(SessionId publisher, const void* endpoint);
  static void CountPublisher(const std::shared_ptr<InboundCore>& core, int change, Actions& actions);

  [[nodiscard]] Demand demand() const;
  void SetDemand(const Demand& demand);
  /// Nothing reaches the sink afterwards; waits for calls inside, except the caller's own.
  void Close() { gate_.Close(); }

  const std::string name;
  const std::string plain_topic;
  const TypeInfo& type;
  std::atomic<std::size_t> publishers{0};

 private:
  [[nodiscard]] std::string TypeFault(const PacketHead& head, const InboundPacket& packet) const;
  [[nodiscard]] bool StartRun();
  void RunApart();

  InboundSink& sink_;  // Called through `gate_` only.
  CallGate gate_;
  RepeatFilter repeats_;
  mutable std::mutex mutex_;
  Demand demand_;
  std::unordered_map<SessionId, const void*> claims_;
  // Runs wait for one another only when many are at work already: a sink has no claim on all threads there are.
  std::size_t running_ = 0;
  std::size_t owed_runs_ = 0;
};

}  // namespace hgros::zmq
