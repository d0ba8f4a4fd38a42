// How a peer that came through shared memory late is moved there from ZeroMQ while messages flow.
#include <utility>

#include "session/carriers.hpp"

namespace hgros {

std::vector<std::shared_ptr<JoinedInbound>> Carriers::Inbound() {
  const std::scoped_lock lock(lists_);
  std::vector<std::shared_ptr<JoinedInbound>> all;
  for (const auto& entry : inbound_) {
    if (auto joined = entry.lock()) all.push_back(std::move(joined));
  }
  return all;
}

// A channel that does not come over ZeroMQ, because an endpoint's list does not let it pass, is there already.
void Carriers::MoveChannel(JoinedInbound& joined, SessionId peer) {
  if (!peers_.Allowed(peer, joined.channel()).all()) return;
  if (!joined.Move(peer, CarrierKind::kShm)) peers_.Moved(peer, joined.channel());
}

void Carriers::BeginMove(SessionId peer) {
  {
    const std::scoped_lock lock(lists_);
    moving_.insert(peer.value);
    for (const auto& entry : inbound_) {
      if (const auto joined = entry.lock()) MoveChannel(*joined, peer);
    }
  }
  // A channel on which nothing is published does not show that it has moved.
  options_.later(options_.zmq.peer_timeout, [this, peer] { FinishMove(peer); });
}

void Carriers::FinishMove(SessionId peer) {
  if (!peers_.FinishMove(peer)) return;
  for (const auto& joined : Inbound()) joined->FinishMove(peer);
  AskAgain(CarrierKind::kShm);
  AskAgain(CarrierKind::kZmq);  // What is still asked for there is let go of.
}

void Carriers::EndMove(SessionId peer, CarrierKind gone) {
  {
    const std::scoped_lock lock(lists_);
    if (moving_.erase(peer.value) == 0) return;
  }
  // Nothing of the carrier that is gone comes any more. What waits for the old one goes on, on a thread that may run
  // user code; what has waited over the new one comes over the old one.
  const auto end = [this, peer, gone] {
    for (const auto& joined : Inbound()) {
      if (gone == CarrierKind::kZmq) joined->FinishMove(peer);
      joined->ForgetMove(peer);
    }
  };
  if (gone == CarrierKind::kZmq) {
    options_.later({}, end);
  } else {
    end();
  }
}

}  // namespace hgros
