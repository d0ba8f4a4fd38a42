#include "transport/peer_registry.hpp"

#include <utility>

namespace hgros {

void PeerRegistry::Came(const PeerInfo& peer) {
  {
    const std::scoped_lock lock(mutex_);
    Entry& entry = peers_[peer.id];
    if (++entry.connections > 1) return;
    entry.info = peer;
  }
  listener_.OnPeerCame(peer);
}

void PeerRegistry::Gone(const PeerInfo& peer, std::string_view reason) {
  PeerInfo known;
  {
    const std::scoped_lock lock(mutex_);
    const auto entry = peers_.find(peer.id);
    if (entry == peers_.end() || --entry->second.connections > 0) return;
    known = std::move(entry->second.info);
    peers_.erase(entry);
  }
  listener_.OnPeerGone(known, reason);
}

std::vector<PeerInfo> PeerRegistry::List() const {
  const std::scoped_lock lock(mutex_);
  std::vector<PeerInfo> list;
  list.reserve(peers_.size());
  for (const auto& [id, entry] : peers_) list.push_back(entry.info);
  return list;
}

}  // namespace hgros
