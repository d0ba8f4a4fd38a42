#include "transport/zmq/session_keys.hpp"

#include <unordered_set>
#include <utility>

namespace hgros::zmq {

SessionKeys::SessionKeys(const PeerRegistry& peers, SessionId self, std::string own_key) : peers_(peers), self_(self) {
  owners_.emplace(self, std::move(own_key));
}

bool SessionKeys::Claim(SessionId session, std::string_view key) {
  if (const auto owner = owners_.find(session); owner != owners_.end()) return owner->second == key;
  if (owners_.size() >= kMaxSessions) {
    std::unordered_set<SessionId> kept{self_};
    for (const PeerInfo& peer : peers_.List()) kept.insert(peer.id);
    std::erase_if(owners_, [&](const auto& entry) { return !kept.contains(entry.first); });
  }
  owners_.emplace(session, key);
  return true;
}

}  // namespace hgros::zmq
