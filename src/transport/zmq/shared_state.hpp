#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "hgros/base/fork_guard.hpp"
#include "hgros/base/ids.hpp"
#include "hgros/base/log.hpp"
#include "hgros/transport/transport.hpp"
#include "hgros/transport/zmq_transport.hpp"
#include "transport/actions.hpp"
#include "transport/agreement.hpp"
#include "transport/peer_registry.hpp"
#include "transport/waker.hpp"
#include "transport/zmq/input_flags.hpp"
#include "transport/zmq/session_keys.hpp"
#include "transport/zmq/session_proof.hpp"
#include "transport/zmq/silence_log.hpp"
#include "transport/zmq/socket.hpp"

namespace hgros::zmq {

using SteadyTime = std::chrono::steady_clock::time_point;

/// The state that all endpoints of one transport share.
/// Thread safety: thread-safe. `options` and `self` never change.
struct SharedState {
  SharedState(ZmqOptions given, TransportListener& told, Log& voice);
  SharedState(const SharedState&) = delete;
  SharedState& operator=(const SharedState&) = delete;

  /// Whether what came over a connection with this key may be in the name of that session; counts and logs it if not.
  /// Always true without keys. On the leading thread.
  [[nodiscard]] bool MayClaim(SessionId session, std::string_view key, std::string_view where);
  /// Counts a packet that was dropped, and logs it at a limited rate. `where` is an endpoint or a peer.
  void CountFault(PacketFault fault, std::string_view where, std::string_view what);
  /// The same for a peer: peers can invent names, so the lines about all of them are limited together.
  void CountPeerFault(PacketFault fault, std::string_view peer, std::string_view what);
  /// The time of this host's wall clock.
  [[nodiscard]] Time Wall() const { return options.wall ? options.wall() : WallNow(); }
  /// What proves to this publisher that a Hello is from this session.
  [[nodiscard]] std::uint64_t ProofFor(SessionId publisher) const { return SessionProof(proof_key_, publisher); }
  /// Logs `unconfirmed`, if there are any.
  void SayUnconfirmed() const;
  /// Passes these calls to the leading thread, which makes them.
  void PostActions(Actions&& actions);
  [[nodiscard]] Actions CollectPosted();
  /// Adds the call that reports to the session: the channels of peers have changed.
  void AddChannelsChanged(Actions& actions) {
    actions.emplace_back([this] { listener.OnChannels(); });
  }

  const ZmqOptions options;
  const SessionFacts self;
  TransportListener& listener;
  Log& log;
  ForkGuard fork;
  const std::shared_ptr<Waker> waker = std::make_shared<Waker>();
  PeerRegistry peers;
  SilenceLog silence{log, options.heartbeat};  ///< For the leading thread.
  std::array<std::atomic<std::uint64_t>, kPacketFaultCount> faults{};
  std::atomic<std::uint64_t> repeats{0};
  std::atomic<std::uint64_t> refused_handshakes{0};  ///< Besides those that the AdmissionDesk has refused.
  // A goodbye follows. ZeroMQ reads few messages ahead, and on ipc it drops what it has not read when a peer closes the
  // connection: many that end subscriptions would keep the goodbye from being read.
  std::atomic<bool> leaving{false};
  std::atomic<bool> closing{false};
  InputFlags input_flags;
  Context context;
  /// At the end of the transport: messages that lossless subscribers may not have received.
  struct Unconfirmed {
    std::uint64_t messages = 0;
    std::string channel{};  ///< One of theirs.
  };
  Unconfirmed unconfirmed;

 private:
  void CountFaultLike(std::string_view alike, PacketFault fault, std::string_view where, std::string_view what);

  SessionKeys session_keys_;
  const ProofKey proof_key_{RandomId(), RandomId()};
  std::mutex posted_mutex_;
  Actions posted_;
};

}  // namespace hgros::zmq
