#include "discovery/beacon/network_interfaces.hpp"

#include <ifaddrs.h>
#include <net/if.h>

#include <algorithm>
#include <cstring>
#include <memory>

#include "hgros/base/readable_text.hpp"
#include "hgros/discovery/announcement.hpp"

namespace hgros::discovery {
namespace {

struct FreeInterfaces {
  void operator()(ifaddrs* list) const { freeifaddrs(list); }
};

in_addr AddressIn(const sockaddr* address) {
  sockaddr_in internet;
  std::memcpy(&internet, address, sizeof internet);
  return internet.sin_addr;
}

}  // namespace

FoundInterfaces FindInterfaces(const std::vector<std::string>& names, in_addr group) {
  FoundInterfaces all;
  for (const std::string& name : names) {
    if (if_nametoindex(name.c_str()) != 0) continue;
    all.faults.push_back("There is no network interface \"" + Readable(name) +
                         "\" for the beacon. It is used as soon as it is there; \"ip link\" shows all names.");
  }
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return all;
  const std::unique_ptr<ifaddrs, FreeInterfaces> owner(list);
  std::vector<NetworkInterface>& found = all.ready;
  for (const ifaddrs* one = list; one != nullptr; one = one->ifa_next) {
    if (one->ifa_addr == nullptr || one->ifa_addr->sa_family != AF_INET || (one->ifa_flags & IFF_UP) == 0) continue;
    const std::string name = one->ifa_name;
    const bool loopback = (one->ifa_flags & IFF_LOOPBACK) != 0;
    if (names.empty() ? loopback : std::find(names.begin(), names.end(), name) == names.end()) continue;
    NetworkInterface entry{.name = name,
                           .index = static_cast<int>(if_nametoindex(one->ifa_name)),
                           .address = AddressIn(one->ifa_addr),
                           .destination = group,
                           // Linux delivers multicast on the loopback, although the interface lacks the flag.
                           .multicast = (one->ifa_flags & IFF_MULTICAST) != 0 || loopback};
    if (!entry.multicast) {
      if ((one->ifa_flags & IFF_BROADCAST) == 0 || one->ifa_broadaddr == nullptr) {
        all.faults.push_back("The beacon finds nobody on network interface \"" + Readable(name) +
                             "\", which has neither multicast nor broadcast. Name the endpoints of the sessions there "
                             "in the configuration.");
        continue;
      }
      entry.destination = AddressIn(one->ifa_broadaddr);
    }
    const bool known = std::any_of(found.begin(), found.end(),
                                   [&](const NetworkInterface& other) { return other.index == entry.index; });
    // The first of several addresses: one datagram per interface is enough, but each network has its own broadcast.
    if (entry.index != 0 && (!known || !entry.multicast)) found.push_back(std::move(entry));
  }
  return all;
}

}  // namespace hgros::discovery
