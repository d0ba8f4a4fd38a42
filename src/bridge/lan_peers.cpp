#include "bridge/lan_peers.hpp"

#include <algorithm>
#include <utility>

namespace hgros {

void LanPeers::OnCame(const Announcement& peer) {
  const std::scoped_lock lock(mutex_);
  Update(peer.session, peer.endpoints);
}

void LanPeers::OnChanged(const Announcement& peer) { OnCame(peer); }

void LanPeers::OnGone(const Announcement& last, std::string_view /*reason*/) {
  const std::scoped_lock lock(mutex_);
  Update(last.session, {});
}

void LanPeers::Configure(const std::string& endpoint) {
  const std::scoped_lock lock(mutex_);
  if (configured_.insert(endpoint).second && heard_.contains(endpoint)) zmq_.RemoveSubscribeEndpoint(endpoint);
}

void LanPeers::Release(const std::string& endpoint) {
  const std::scoped_lock lock(mutex_);
  if (configured_.erase(endpoint) > 0 && heard_.contains(endpoint)) Connect(endpoint);
}

void LanPeers::Connect(const std::string& endpoint) {
  if (configured_.contains(endpoint)) return;
  try {
    zmq_.AddSubscribeEndpoint({endpoint, std::nullopt, {}});
  } catch (const std::exception& error) {
    log_.WriteLimited(LogLevel::kWarning, "lan " + endpoint,
                      std::string("No connection to a session that the beacon hears. ") + error.what());
  }
}

void LanPeers::Update(SessionId session, const std::vector<std::string>& endpoints) {
  for (auto entry = heard_.begin(); entry != heard_.end();) {
    const bool stays = std::ranges::find(endpoints, entry->first) != endpoints.end();
    if (!stays && entry->second.erase(session) > 0 && entry->second.empty()) {
      if (!configured_.contains(entry->first)) zmq_.RemoveSubscribeEndpoint(entry->first);
      entry = heard_.erase(entry);
    } else {
      ++entry;
    }
  }
  for (const std::string& endpoint : endpoints) {
    std::unordered_set<SessionId>& sessions = heard_[endpoint];
    const bool first = sessions.empty();
    sessions.insert(session);
    if (first) Connect(endpoint);
  }
}

bool ReachesOtherHosts(std::string_view endpoint) noexcept {
  constexpr std::string_view kTcp = "tcp://";
  if (!endpoint.starts_with(kTcp)) return false;
  const std::string_view host = endpoint.substr(kTcp.size());
  return !host.starts_with("127.") && !host.starts_with("localhost:") && !host.starts_with('[');  // A beacon uses IPv4.
}

}  // namespace hgros
