#include "discovery/beacon/beacon_peers.hpp"

#include <algorithm>

namespace hgros::discovery {

BeaconPeers::Verdict BeaconPeers::Hear(const Heard& heard, const std::string& sender, Clock::time_point now) {
  Expire(now);
  const SessionId session = heard.peer.session;
  auto entry = peers_.find(session);
  if (entry == peers_.end()) {
    if (heard.ends) return Verdict::kIgnored;
    if (peers_.size() >= kMaxPeers && !MakeRoomFor(sender)) return Verdict::kTooMany;
    peers_.emplace(session, Peer{sender, heard.peer.incarnation, now});
    by_sender_[sender].insert(session);
    book_.Put(heard.peer);
    return Verdict::kNew;
  }
  Peer& peer = entry->second;
  if (peer.sender != sender || heard.peer.incarnation < peer.incarnation) return Verdict::kIgnored;
  if (heard.ends) {
    Remove(entry, "It said goodbye.");
    return Verdict::kKnown;
  }
  const bool reborn = heard.peer.incarnation != peer.incarnation;
  peer.incarnation = heard.peer.incarnation;
  peer.last_heard = now;
  book_.Put(heard.peer);
  return reborn ? Verdict::kNew : Verdict::kKnown;
}

BeaconPeers::Peers::iterator BeaconPeers::Remove(Peers::iterator entry, std::string_view reason) {
  book_.Remove(entry->first, reason);
  const auto sessions = by_sender_.find(entry->second.sender);
  sessions->second.erase(entry->first);
  if (sessions->second.empty()) by_sender_.erase(sessions);
  return peers_.erase(entry);
}

bool BeaconPeers::MakeRoomFor(const std::string& sender) {
  const auto most = std::ranges::max_element(by_sender_, {}, [](const auto& entry) { return entry.second.size(); });
  const auto own = by_sender_.find(sender);
  const std::size_t count = own == by_sender_.end() ? 0 : own->second.size();
  if (most == by_sender_.end() || most->second.size() <= count + 1) return false;
  Remove(peers_.find(*most->second.begin()), "Its host announces too many sessions.");
  return true;
}

void BeaconPeers::Expire(Clock::time_point now) {
  for (auto entry = peers_.begin(); entry != peers_.end();) {
    if (now - entry->second.last_heard < patience_) {
      ++entry;
      continue;
    }
    entry = Remove(entry, "It was not heard for " + std::to_string(patience_.count()) + " ms.");
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
