#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "hgros/control.pb.h"
#include "transport/zmq/arrival_wait.hpp"
#include "transport/zmq/publish/connection_watch.hpp"
#include "transport/zmq/publish/published_channels.hpp"
#include "transport/zmq/publish/subscriber_peer.hpp"
#include "transport/zmq/shared_state.hpp"

namespace hgros::zmq {

/// The sessions that subscribe at one publish endpoint: their handshakes, heartbeats and ends.
///
/// Thread safety: none; the endpoint's mutex guards it.
/// Invariants: a peer is a session whose Hello answered our last Welcome. Between a Welcome that pauses and the
/// Subscribe that answers it a link is paused. So after it has seen the Welcome, the subscriber gets no further message
/// that was sent before it. Anybody can ask for a Welcome in a session's name: it pauses nothing while the session may
/// still be there, until a Hello with its proof comes over another connection.
class SubscriberPeers {
 public:
  using LinkEnd = PublishedChannels::LinkEnd;
  /// `endpoint` is where it is bound, for the log.
  SubscriberPeers(SharedState& shared, Socket& socket, PublishedChannels& channels, ConnectionWatch& watch,
                  const std::string& endpoint);

  /// Null if that session is not a peer.
  [[nodiscard]] SubscriberPeer* Find(SessionId session);
  /// The peers that wait for a link to this channel.
  [[nodiscard]] std::vector<SubscriberPeer*> FindWaiting(const std::string& channel);
  void Send(const SubscriberPeer& peer, const wire::Control& control) { Send(peer.topic, control, peer.connection); }

  /// Sends a Welcome, which begins a new handshake. Does not repeat it within a short time, unless `at_once` is set.
  /// `connection`: the descriptor over which it was asked for. Pauses the links if that is the session's.
  void Greet(SessionId session, int connection, bool at_once);
  /// Whether the connection is there, and is that session's.
  [[nodiscard]] bool IsAt(const SubscriberPeer& peer, int connection) {
    return watch_.MaySpeakFor(connection, peer.facts.info.id, peer.proof);
  }
  /// Pauses the links, and sends a Welcome.
  void BeginAgain(SubscriberPeer& peer, int connection);
  /// Ignores it if it answers an older Welcome, or is not from the session that it names. `connection`: the descriptor
  /// that it came over.
  void OnHello(SessionId session, const wire::Hello& hello, int connection, Actions& actions);
  void OnHeartbeat(SubscriberPeer& peer, const wire::Heartbeat& heartbeat, Actions& actions);
  /// The session has unsubscribed from its control topic, or its connection has ended.
  void OnDisconnected(SessionId session, Actions& actions);
  /// Another session publishes where this one did. It is dropped as soon as its connection is closed, or it is silent.
  void OnReplaced(SessionId session, Actions& actions);
  void Drop(SessionId session, std::string_view reason, Actions& actions, LinkEnd links = LinkEnd::kLost);

  /// Sends Offers to all peers: the channel is now offered, or no longer.
  void AnnounceOffer(const OutboundCore& core, bool came);
  /// Reports the mismatch to this session, once per peer and channel.
  void ReportMismatch(SubscriberPeer& peer, const std::string& channel, const std::string& what, Actions& actions);

  void Tick(SteadyTime now, Actions& actions);
  /// Counts all peers as heard now.
  void ForgiveSilence(SteadyTime now);
  /// Adds what peers may not have received yet. Asks each of them once everything was sent to it.
  void LookAtArriving(Arriving& arriving);
  /// Adds the messages of lossless channels that were sent, and may not have been received.
  void AddUnconfirmed(SharedState::Unconfirmed& unconfirmed) const;
  /// Adds the sessions that subscribe here, with their channels.
  void AddWishes(std::vector<SessionChannels>& known) const;
  /// Sends Bye to all.
  void DropAll(std::string_view reason, Actions& actions);

 private:
  struct Greeting {
    std::uint64_t handshake = 0;
    SteadyTime when{};
    // The offers have changed since the Welcome, but there was no peer to send Offers to.
    bool stale = false;
    std::set<std::string> gone;
  };
  void Send(const std::string& topic, const wire::Control& control, int connection);
  void SendWelcome(SessionId session, int connection);
  void RepeatOffers(const SubscriberPeer& peer, Greeting& greeting);
  static void PauseLinks(SubscriberPeer& peer);

  SharedState& shared_;
  Socket& socket_;
  PublishedChannels& channels_;
  ConnectionWatch& watch_;
  const std::string& endpoint_;
  std::unordered_map<SessionId, std::unique_ptr<SubscriberPeer>> peers_;
  std::unordered_map<SessionId, Greeting> greetings_;
  std::uint64_t last_handshake_;
};

}  // namespace hgros::zmq
