#pragma once

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "support/relay_port.hpp"

namespace hgros::test {

/// Whether this process now owns the port among all tests. The socket that shows it stays open until the process ends.
inline bool ClaimPort(std::uint16_t port) {
  const std::string name = "hgros-test-port-" + std::to_string(port);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  name.copy(address.sun_path + 1, name.size());  // In the abstract namespace.
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
  const int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (bind(fd, reinterpret_cast<const sockaddr*>(&address), size) == 0) return true;
  close(fd);
  return false;
}

/// A free port of the loopback. No other test gets it while this process lives, also while nobody has bound it. It is
/// below those that the system gives to outgoing connections. A program that repeatedly connects to a port of that
/// range could get the same port for its own end, and so be connected to itself.
inline std::uint16_t FreePort() {
  static int next = getpid() % 18000 * 37;
  for (int tries = 0; tries < 1000; ++tries) {
    const auto port = static_cast<std::uint16_t>(12000 + next++ % 18000);
    if (!ClaimPort(port)) continue;
    const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const sockaddr_in address = LoopbackAddress(port);
    const bool free = bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
    close(fd);
    if (free) return port;
  }
  throw std::runtime_error("no free port");
}

}  // namespace hgros::test
