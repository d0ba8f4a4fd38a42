#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <optional>
#include <stdexcept>

namespace hgros::test {

inline sockaddr_in LoopbackAddress(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

/// A TCP port on loopback, chosen by the system. The test forwards its connections to another port.
class RelayPort {
 public:
  explicit RelayPort(std::uint16_t target_port, const char* target_ip = "127.0.0.1")
      : target_(LoopbackAddress(target_port)), listener_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    target_.sin_addr.s_addr = inet_addr(target_ip);
    sockaddr_in address = LoopbackAddress(0);
    socklen_t size = sizeof address;
    if (bind(listener_, reinterpret_cast<sockaddr*>(&address), size) != 0 || listen(listener_, 16) != 0 ||
        getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
      close(listener_);
      throw std::runtime_error("no port to relay");
    }
    port_ = ntohs(address.sin_port);
  }
  RelayPort(const RelayPort&) = delete;
  RelayPort& operator=(const RelayPort&) = delete;
  ~RelayPort() { close(listener_); }

  [[nodiscard]] std::uint16_t port() const { return port_; }
  /// Becomes readable when a connection waits.
  [[nodiscard]] int listener() const { return listener_; }

  /// The two sockets of a relayed connection. The owner closes them.
  struct Pair {
    int client = -1;
    int server = -1;

    void Close() const {
      close(client);
      close(server);
    }
  };
  /// Accepts the waiting connection and connects to the other port. Empty if that fails.
  [[nodiscard]] std::optional<Pair> Accept() const {
    const Pair pair{accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC), socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)};
    const int one = 1;
    setsockopt(pair.client, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
    setsockopt(pair.server, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
    if (pair.client >= 0 && connect(pair.server, reinterpret_cast<const sockaddr*>(&target_), sizeof target_) == 0) {
      return pair;
    }
    pair.Close();
    return std::nullopt;
  }
  /// Accepts the waiting connection and closes it.
  void Refuse() const { close(accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC)); }

 private:
  sockaddr_in target_;
  const int listener_;
  std::uint16_t port_ = 0;
};

}  // namespace hgros::test
