// Moves a peer's messages to another transport: to a cheaper one that reaches the peer later, while messages flow; or
// to a remaining one when a transport loses the peer.
#include <utility>

#include "bridge/bridge_core.hpp"

namespace hgros {

template <class Joined>
std::vector<std::shared_ptr<Joined>> BridgeCore::Listed(const std::vector<std::weak_ptr<Joined>>& list) {
  const std::scoped_lock lock(lists_);
  std::vector<std::shared_ptr<Joined>> all;
  for (const auto& entry : list) {
    if (auto joined = entry.lock()) all.push_back(std::move(joined));
  }
  return all;
}

// A channel that does not come over the old transport, because an endpoint's list does not allow it, has already
// moved.
void BridgeCore::MoveChannel(JoinedInbound& joined, SessionId peer) {
  const auto way = peers_.MoveOf(peer, joined.channel());
  if (way && !joined.Move(peer, *way)) peers_.Moved(peer, joined.channel());
}

void BridgeCore::BeginMove(SessionId peer, PeerTransports::MoveNumber number) {
  {
    const std::scoped_lock lock(lists_);
    for (const auto& entry : inbound_) {
      if (const auto joined = entry.lock()) MoveChannel(*joined, peer);
    }
    peers_.OpenMove(peer);
  }
  // A channel on which nothing is published does not show that it has moved.
  options_.later(options_.zmq.peer_timeout, [this, peer, number] { FinishMove(peer, number); });
}

void BridgeCore::FinishMove(SessionId peer, PeerTransports::MoveNumber number) {
  if (!peers_.FinishMove(peer, number)) return;
  for (const auto& joined : Listed(inbound_)) joined->FinishMove(peer);
  if (const auto next = peers_.NextMove(peer)) BeginMove(peer, *next);
  AskAgain();  // Channels that are still asked for over the old transport are dropped there.
}

// A living session of this host comes back over a transport of this host, or over another one after these were given
// up.
void BridgeCore::AwaitSubscriber(SessionId subscriber, JoinedOutbound::Abandon give_up) {
  const bool lives = peers_.IsFound(subscriber);
  // Later its name is not known any more.
  options_.later(lives ? HostPairs::kHostPatience + options_.zmq.peer_timeout : std::chrono::nanoseconds(0),
                 [give_up = std::move(give_up), name = peers_.NameOf(subscriber)] { give_up(name); });
}

void BridgeCore::GiveUpSubscriber(const PeerInfo& subscriber) {
  for (const auto& joined : Listed(outbound_)) joined->GiveUp(subscriber.id, subscriber.name());
}

// If a channel may no longer use both transports of its move, its messages are delivered as they come. Those that have
// waited on the new transport also come over the old one, unless that is the one that it may not use.
void BridgeCore::ForgetForbiddenMoves(SessionId peer) {
  for (const auto& joined : Listed(inbound_)) {
    const TransportSet allowed = peers_.Allowed(peer, joined->channel());
    joined->ForgetMove(peer, [allowed](MoveWay way) { return allowed.Has(way.from) && !allowed.Has(way.to); });
  }
  options_.later({}, [this, peer] {
    for (const auto& joined : Listed(inbound_)) {
      const TransportSet allowed = peers_.Allowed(peer, joined->channel());
      EndMoves(*joined, peer, [allowed](MoveWay way) { return !allowed.Has(way.from); });
    }
  });
}

// On a thread that may run user code.
void BridgeCore::EndMoves(JoinedInbound& joined, SessionId peer, const JoinedInbound::Which& which) {
  joined.FinishMove(peer, which);
  joined.ForgetMove(peer, which);
}

void BridgeCore::EndMove(SessionId peer, TransportIndex gone) {
  // Messages that have waited on the new transport also come over the old one.
  for (const auto& joined : Listed(inbound_)) joined->ForgetMove(peer, [gone](MoveWay way) { return way.to == gone; });
  // No more messages come over the old transport: those that wait for it are delivered now, on a thread that may run
  // user code.
  options_.later({}, [this, peer, gone] {
    const auto from_there = [gone](MoveWay way) { return way.from == gone; };
    for (const auto& joined : Listed(inbound_)) EndMoves(*joined, peer, from_there);
    if (const auto next = peers_.NextMove(peer)) {
      BeginMove(peer, *next);
      AskAgain();
    }
  });
}

}  // namespace hgros
