#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "hgros/bridge/network_bridge.hpp"
#include "hgros/clock/host_clocks.hpp"
#include "hgros/config/config.hpp"

namespace hgros {

// How other sessions know a session.
struct BridgeIdentity {
  SessionId id;
  const std::string& name;
  const std::optional<std::string>& domain;  // Empty: no discovery.
  std::chrono::milliseconds linger;
};

// The transports and ways of discovery that the configuration asks for.
[[nodiscard]] BridgeOptions BridgeOptionsOf(const Config& config, const BridgeIdentity& self,
                                            const std::shared_ptr<HostClocks>& clocks);

}  // namespace hgros
