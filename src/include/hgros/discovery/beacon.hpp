#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hgros/base/export.hpp"
#include "hgros/base/log.hpp"
#include "hgros/discovery/discovery.hpp"
#include "hgros/discovery/domain.hpp"

namespace hgros {

inline constexpr std::string_view kBeaconGroup = "239.255.72.71";
inline constexpr std::uint16_t kBeaconPort = 17271;

struct BeaconOptions {
  std::string domain = std::string(kDefaultDomain);
  /// Names of network interfaces, such as "eth0"; empty: all except the loopback. Interfaces may appear later.
  std::vector<std::string> interfaces = {};
  std::uint16_t port = kBeaconPort;
  std::chrono::milliseconds period = std::chrono::seconds(1);    ///< Time between two datagrams without news.
  std::chrono::milliseconds patience = std::chrono::seconds(5);  ///< A peer that was silent this long is gone.
};

/// Finds sessions of other hosts on the same network (IPv4, no router in between). Each session sends a datagram once
/// per period, when it has news, and when it hears a new peer: by multicast to kBeaconGroup, or by broadcast on an
/// interface without multicast. Datagrams contain only the tcp endpoints that other hosts can reach, and no channels:
/// those are exchanged over the connection. The host "*" in an endpoint is replaced by the sender's address.
///
/// Anyone on the network can send such datagrams: they are a hint, not a proof. Sizes, rates and the number of peers
/// are limited. docs/decisions/0010-discovery.md has the format.
///
/// Errors: throws Error if the port cannot be opened. Interfaces that are missing or cannot be used are logged once.
[[nodiscard]] HGROS_EXPORT std::unique_ptr<Discovery> OpenBeacon(const BeaconOptions& options,
                                                                 DiscoveryListener& listener, Log& log);

}  // namespace hgros
