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
  /// The network interfaces by name, as in "eth0"; empty: all but the loopback, also those that come later.
  std::vector<std::string> interfaces = {};
  std::uint16_t port = kBeaconPort;
  std::chrono::milliseconds period = std::chrono::seconds(1);    ///< Between two datagrams of one who has no news.
  std::chrono::milliseconds patience = std::chrono::seconds(5);  ///< Who was not heard for so long is gone.
};

/// Finds sessions of other hosts on the same network (IPv4, no router between): each sends a datagram once a period,
/// when it has news, and when it hears somebody new, by multicast to kBeaconGroup, or by broadcast where an interface
/// has no multicast. Only the tcp endpoints that other hosts can reach are told, and no channels: those come over the
/// connection. A host of "*" in an endpoint is replaced by the address that the datagram came from.
///
/// Anyone on the network can send such datagrams: what is heard is a hint, not a proof. Sizes, rates and the number of
/// peers are limited. The format is in docs/decisions/0010-discovery.md.
///
/// Errors: throws Error if the port cannot be opened or an interface in the options does not exist.
[[nodiscard]] HGROS_EXPORT std::unique_ptr<Discovery> OpenBeacon(const BeaconOptions& options,
                                                                 DiscoveryListener& listener, Log& log);

}  // namespace hgros
