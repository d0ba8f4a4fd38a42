#include "discovery/beacon/beacon_peers.hpp"

#include <algorithm>
#include <utility>

namespace hgros::discovery {

BeaconPeers::Verdict BeaconPeers::Hear(const Heard& heard, const std::string& sender, Clock::time_point now) {
  Expire(now);
  const SessionId session = heard.peer.session;
  auto entry = peers_.find(session);
  if (entry == peers_.end()) {
    if (heard.ends) return Verdict::kIgnored;
    if (peers_.size() >= kMaxPeers && !MakeRoomFor(sender)) return Verdict::kTooMany;
    peers_.emplace(session, Places{{sender, heard.peer, now}});
    by_sender_[sender].insert(session);
    book_.Put(heard.peer);
    return Verdict::kNew;
  }
  Places& places = entry->second;
  const auto place = std::ranges::find(places, sender, &Place::sender);
  if (place == places.end()) {
    if (heard.ends) return Verdict::kIgnored;
    const bool full = places.size() >= kMaxPlaces;
    if (full) RemoveFirstPlace(*entry);
    places.push_back({sender, heard.peer, now});
    book_.Put(Merged(places));
    return full ? Verdict::kKnown : Verdict::kNew;  // With more addresses than that, each one would be new for ever.
  }
  if (heard.peer.incarnation < place->peer.incarnation) return Verdict::kIgnored;
  if (heard.ends) {
    (void)RemoveIf(
        entry, [&](const Place& one) { return one.sender == sender; }, "It said goodbye.");
    return Verdict::kKnown;
  }
  const bool reborn = heard.peer.incarnation != place->peer.incarnation;
  place->peer = heard.peer;
  place->last_heard = now;
  book_.Put(Merged(places));
  return reborn ? Verdict::kNew : Verdict::kKnown;
}

Announcement BeaconPeers::Merged(const Places& places) {
  Announcement merged = places.front().peer;
  if (places.size() == 1) return merged;
  merged.senders.assign(merged.endpoints.size(), places.front().sender);
  for (const Place& place : places) {
    for (const std::string& endpoint : place.peer.endpoints) {
      if (std::ranges::find(merged.endpoints, endpoint) != merged.endpoints.end()) continue;
      merged.endpoints.push_back(endpoint);
      merged.senders.push_back(place.sender);
    }
  }
  return merged;
}

void BeaconPeers::ForgetSender(const std::string& sender, SessionId session) {
  const auto sessions = by_sender_.find(sender);
  sessions->second.erase(session);
  if (sessions->second.empty()) by_sender_.erase(sessions);
}

// The next one describes the peer.
void BeaconPeers::RemoveFirstPlace(Peers::value_type& entry) {
  auto& [session, places] = entry;
  ForgetSender(places.front().sender, session);
  places.erase(places.begin());
  if (!places.empty()) by_sender_[places.front().sender].insert(session);
}

template <class Ended>
BeaconPeers::Peers::iterator BeaconPeers::RemoveIf(Peers::iterator entry, const Ended& ended, std::string_view reason) {
  auto& [session, places] = *entry;
  const std::size_t before = places.size();
  while (!places.empty() && ended(places.front())) RemoveFirstPlace(*entry);
  std::erase_if(places, ended);
  if (places.empty()) {
    book_.Remove(session, reason);
    return peers_.erase(entry);
  }
  if (places.size() != before) book_.Put(Merged(places));
  return std::next(entry);
}

bool BeaconPeers::MakeRoomFor(const std::string& sender) {
  const auto most = std::ranges::max_element(by_sender_, {}, [](const auto& entry) { return entry.second.size(); });
  const auto own = by_sender_.find(sender);
  const std::size_t count = own == by_sender_.end() ? 0 : own->second.size();
  if (most == by_sender_.end() || most->second.size() <= count + 1) return false;
  const auto everywhere = [](const Place&) { return true; };
  (void)RemoveIf(peers_.find(*most->second.begin()), everywhere, "Its host announces too many sessions.");
  return true;
}

void BeaconPeers::Expire(Clock::time_point now) {
  const auto ended = [&](const Place& place) { return now - place.last_heard >= patience_; };
  const std::string reason = "It was not heard for " + std::to_string(patience_.count()) + " ms.";
  for (auto entry = peers_.begin(); entry != peers_.end();) entry = RemoveIf(entry, ended, reason);
}

std::optional<BeaconPeers::Clock::time_point> BeaconPeers::next_expiry() const {
  std::optional<Clock::time_point> first;
  for (const auto& [session, places] : peers_) {
    for (const Place& place : places) {
      const Clock::time_point expiry = place.last_heard + patience_;
      first = first ? std::min(*first, expiry) : expiry;
    }
  }
  return first;
}

}  // namespace hgros::discovery
