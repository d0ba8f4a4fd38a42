// How a peer's messages come over another carrier than before: those of one that shared memory reaches late, while they
// flow; and those of one that a carrier has lost, when it is back.
#include <utility>

#include "session/carriers.hpp"

namespace hgros {

template <class Joined>
std::vector<std::shared_ptr<Joined>> Carriers::Listed(const std::vector<std::weak_ptr<Joined>>& list) {
  const std::scoped_lock lock(lists_);
  std::vector<std::shared_ptr<Joined>> all;
  for (const auto& entry : list) {
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
  for (const auto& joined : Listed(inbound_)) joined->FinishMove(peer);
  AskAgain(CarrierKind::kShm);
  AskAgain(CarrierKind::kZmq);  // What is still asked for there is let go of.
}

// A session of this host that lives comes back through shared memory, or over ZeroMQ when that has been given up.
void Carriers::AwaitSubscriber(SessionId subscriber, std::function<void()> give_up) {
  const bool lives = peers_.IsFound(subscriber);
  options_.later(lives ? kSharedMemoryPatience + options_.zmq.peer_timeout : std::chrono::nanoseconds(0),
                 std::move(give_up));
}

void Carriers::GiveUpSubscriber(SessionId subscriber) {
  for (const auto& joined : Listed(outbound_)) joined->GiveUp(subscriber);
}

// What has a rule now goes on as it comes.
void Carriers::ForgetRuledMoves(SessionId peer) {
  for (const auto& joined : Listed(inbound_)) {
    if (!peers_.Allowed(peer, joined->channel()).all()) joined->ForgetMove(peer);
  }
}

void Carriers::EndMove(SessionId peer, CarrierKind gone) {
  {
    const std::scoped_lock lock(lists_);
    if (moving_.erase(peer.value) == 0) return;
  }
  // Nothing of the carrier that is gone comes any more. What waits for the old one goes on, on a thread that may run
  // user code; what has waited over the new one comes over the old one.
  const auto end = [this, peer, gone] {
    for (const auto& joined : Listed(inbound_)) {
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
