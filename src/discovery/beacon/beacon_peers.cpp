#include "discovery/beacon/beacon_peers.hpp"

#include <algorithm>

namespace hgros::discovery {

BeaconPeers::Verdict BeaconPeers::Hear(const Heard& heard, const std::string& sender, Clock::time_point now) {
  Expire(now);
  const SessionId session = heard.peer.session;
  auto entry = peers_.find(session);
  if (entry == peers_.end()) {
    if (heard.ends) return Verdict::kIgnored;
    if (peers_.size() >= kMaxPeers) return Verdict::kTooMany;
    peers_.emplace(session, Peer{sender, heard.peer.incarnation, now});
    book_.Put(heard.peer);
    return Verdict::kNew;
  }
  Peer& peer = entry->second;
  if (peer.sender != sender || heard.peer.incarnation < peer.incarnation) return Verdict::kIgnored;
  if (heard.ends) {
    peers_.erase(entry);
    book_.Remove(session, "It said goodbye.");
    return Verdict::kKnown;
  }
  const bool reborn = heard.peer.incarnation != peer.incarnation;
  peer.incarnation = heard.peer.incarnation;
  peer.last_heard = now;
  book_.Put(heard.peer);
  return reborn ? Verdict::kNew : Verdict::kKnown;
}

void BeaconPeers::Expire(Clock::time_point now) {
  for (auto entry = peers_.begin(); entry != peers_.end();) {
    if (now - entry->second.last_heard < patience_) {
      ++entry;
      continue;
    }
    book_.Remove(entry->first, "It was not heard for " + std::to_string(patience_.count()) + " ms.");
    entry = peers_.erase(entry);
  }
}

std::optional<BeaconPeers::Clock::time_point> BeaconPeers::next_expiry() const {
  std::optional<Clock::time_point> first;
  for (const auto& [session, peer] : peers_) {
    const Clock::time_point expiry = peer.last_heard + patience_;
    first = first ? std::min(*first, expiry) : expiry;
  }
  return first;
}

}  // namespace hgros::discovery
