#include "discovery/beacon/beacon_socket.hpp"

#include <arpa/inet.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/discovery/beacon.hpp"

namespace hgros::discovery {
namespace {

void SetOption(int fd, int level, int option, int value) {
  if (setsockopt(fd, level, option, &value, sizeof value) == 0) return;
  throw Error(std::string("The beacon's socket cannot be set up: ") + std::strerror(errno) + ".");
}

// Room for one in_pktinfo.
struct alignas(cmsghdr) ControlBuffer {
  std::array<char, CMSG_SPACE(sizeof(in_pktinfo))> bytes{};
};

}  // namespace

std::string AddressText(in_addr address) {
  std::array<char, INET_ADDRSTRLEN> text{};
  return inet_ntop(AF_INET, &address, text.data(), text.size()) == nullptr ? std::string() : text.data();
}

BeaconSocket::BeaconSocket(std::vector<std::string> interface_names, std::uint16_t port)
    : names_(std::move(interface_names)),
      port_(port),
      socket_([] { return socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0); }) {
  inet_pton(AF_INET, std::string(kBeaconGroup).c_str(), &group_);
  const int fd = socket_.get();
  // All sessions of a host share the port: each gets every multicast and broadcast datagram.
  SetOption(fd, SOL_SOCKET, SO_REUSEADDR, 1);
  SetOption(fd, SOL_SOCKET, SO_BROADCAST, 1);
  SetOption(fd, IPPROTO_IP, IP_MULTICAST_ALL, 0);
  SetOption(fd, IPPROTO_IP, IP_MULTICAST_TTL, 1);
  SetOption(fd, IPPROTO_IP, IP_TTL, 1);
  SetOption(fd, IPPROTO_IP, IP_PKTINFO, 1);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port_);
  address.sin_addr.s_addr = htonl(INADDR_ANY);
  if (bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    throw Error("The beacon cannot listen on UDP port " + std::to_string(port_) + ": " + std::strerror(errno) + ".", {},
                "End the program that uses this port alone, or choose another port on every host.");
  }
  (void)Refresh();
}

std::vector<std::string> BeaconSocket::Refresh() {
  FoundInterfaces now = FindInterfaces(names_, group_);
  if (now.ready == interfaces_) return std::move(now.faults);
  for (const NetworkInterface& one : now.ready) Join(one);
  const std::scoped_lock lock(mutex_);
  interfaces_ = std::move(now.ready);
  return std::move(now.faults);
}

void BeaconSocket::Join(const NetworkInterface& one) noexcept {
  if (!one.multicast) return;
  ip_mreqn membership{};
  membership.imr_multiaddr = group_;
  membership.imr_ifindex = one.index;
  // The socket may already be a member. Memberships of removed interfaces have ended with them.
  (void)setsockopt(socket_.get(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership);
}

std::string BeaconSocket::Send(std::string_view datagram) const {
  std::vector<NetworkInterface> interfaces;
  {
    const std::scoped_lock lock(mutex_);
    interfaces = interfaces_;
  }
  std::string fault;
  for (const NetworkInterface& one : interfaces) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port_);
    to.sin_addr = one.destination;
    iovec piece{const_cast<char*>(datagram.data()), datagram.size()};
    ControlBuffer control;
    msghdr message{};
    message.msg_name = &to;
    message.msg_namelen = sizeof to;
    message.msg_iov = &piece;
    message.msg_iovlen = 1;
    message.msg_control = control.bytes.data();
    message.msg_controllen = control.bytes.size();
    cmsghdr* header = CMSG_FIRSTHDR(&message);
    header->cmsg_level = IPPROTO_IP;
    header->cmsg_type = IP_PKTINFO;
    header->cmsg_len = CMSG_LEN(sizeof(in_pktinfo));
    in_pktinfo route{};
    route.ipi_ifindex = one.index;
    route.ipi_spec_dst = one.address;
    std::memcpy(CMSG_DATA(header), &route, sizeof route);
    if (sendmsg(socket_.get(), &message, MSG_NOSIGNAL) < 0) fault = one.name + ": " + std::strerror(errno);
  }
  return fault;
}

std::optional<BeaconSocket::Datagram> BeaconSocket::Receive(std::span<std::byte> buffer) {
  sockaddr_in from{};
  iovec piece{buffer.data(), buffer.size()};
  ControlBuffer control;
  msghdr message{};
  message.msg_name = &from;
  message.msg_namelen = sizeof from;
  message.msg_iov = &piece;
  message.msg_iovlen = 1;
  message.msg_control = control.bytes.data();
  message.msg_controllen = control.bytes.size();
  ssize_t size = 0;
  do {
    size = recvmsg(socket_.get(), &message, 0);
  } while (size < 0 && errno == EINTR);
  if (size < 0) return std::nullopt;
  Datagram datagram{{}, from.sin_addr};
  if ((message.msg_flags & MSG_TRUNC) != 0 || from.sin_family != AF_INET) return datagram;
  for (cmsghdr* header = CMSG_FIRSTHDR(&message); header != nullptr; header = CMSG_NXTHDR(&message, header)) {
    if (header->cmsg_level != IPPROTO_IP || header->cmsg_type != IP_PKTINFO) continue;
    in_pktinfo route{};
    std::memcpy(&route, CMSG_DATA(header), sizeof route);
    const bool chosen = std::any_of(interfaces_.begin(), interfaces_.end(),
                                    [&](const NetworkInterface& one) { return one.index == route.ipi_ifindex; });
    if (chosen) datagram.bytes = buffer.first(static_cast<std::size_t>(size));
  }
  return datagram;
}

}  // namespace hgros::discovery
