#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "hgros/base/ids.hpp"
#include "hgros/bridge/channel_traffic.hpp"
#include "hgros/graph/snapshot.hpp"
#include "hgros/services/service_snapshot.hpp"
#include "hgros/transport/peer_info.hpp"
#include "hgros/transport/transport_stats.hpp"

namespace hgros {

/// Everything a session counts, at one moment.
struct SessionSnapshot {
  SessionId id;
  std::string name;
  GraphSnapshot graph;
  std::vector<ChannelTraffic> traffic;    ///< Sorted by channel; only channels that reach outside.
  std::vector<ServiceSnapshot> services;  ///< Sorted by name.
  std::vector<PeerInfo> peers;
  TransportStats transport;
  /// By channel: a sentence that says why no message of it leaves the session, or enters it. Channels without one may.
  std::map<std::string, std::string, std::less<>> not_leaving;
  std::map<std::string, std::string, std::less<>> not_entering;
  std::set<std::string, std::less<>> forbidden;  ///< Those of them that AskSessions() has forbidden.
  bool steerable = false;                        ///< Others may ask it to change something: AskSessions().
  std::uint64_t refused_orders = 0;
};

}  // namespace hgros
