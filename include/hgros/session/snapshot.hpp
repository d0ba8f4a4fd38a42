#pragma once

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
};

}  // namespace hgros
