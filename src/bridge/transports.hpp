#pragma once

#include "hgros/bridge/network_bridge.hpp"
#include "hgros/bridge/transport_list.hpp"

namespace hgros {

/// The transports of a session with these options.
[[nodiscard]] TransportList TransportsOf(const BridgeOptions& options);

}  // namespace hgros
