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

struct FoundInterfaces {
  std::vector<NetworkInterface> ready;
  std::vector<std::string> faults;  ///< Sentences about interfaces that do not exist or cannot be used.
};

/// The interfaces in `names`; without names, all except the loopback. An interface without multicast and broadcast
/// cannot be used, except a loopback that was named.
[[nodiscard]] FoundInterfaces FindInterfaces(const std::vector<std::string>& names, in_addr group);

}  // namespace hgros::discovery
