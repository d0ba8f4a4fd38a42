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
  in_addr destination{};  ///< Where everyone on its network listens: the group, or the broadcast address.
  bool multicast = false;

  [[nodiscard]] bool operator==(const NetworkInterface& other) const {
    return index == other.index && address.s_addr == other.address.s_addr &&
           destination.s_addr == other.destination.s_addr;
  }
};

/// Those of the interfaces in `names` that are ready; of all but the loopback if there are no names. One that has
/// neither multicast nor broadcast is left out, but for a loopback that is asked for by name.
[[nodiscard]] std::vector<NetworkInterface> FindInterfaces(const std::vector<std::string>& names, in_addr group);

/// Throws Error naming the interface if there is none of that name, whether ready or not.
void RequireInterfaces(const std::vector<std::string>& names);

}  // namespace hgros::discovery
