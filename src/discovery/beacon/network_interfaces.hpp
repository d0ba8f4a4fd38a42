#pragma once

#include <netinet/in.h>

#include <string>
#include <vector>

namespace hgros::discovery {

/// An interface that is up and has an IPv4 address.
struct NetworkInterface {
  std::string name;
  int index = 0;
  in_addr address{};
  in_addr destination{};  ///< Address of all hosts on its network: the group, or the broadcast address.
  bool multicast = false;

  [[nodiscard]] bool operator==(const NetworkInterface& other) const {
    return index == other.index && address.s_addr == other.address.s_addr &&
           destination.s_addr == other.destination.s_addr;
  }
};

/// The interfaces in `names` that are ready; without names, all except the loopback. An interface without multicast and
/// broadcast is left out, except a loopback that was named.
[[nodiscard]] std::vector<NetworkInterface> FindInterfaces(const std::vector<std::string>& names, in_addr group);

/// Throws Error naming the first interface that does not exist, whether ready or not.
void RequireInterfaces(const std::vector<std::string>& names);

}  // namespace hgros::discovery
