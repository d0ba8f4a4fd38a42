#pragma once

#include <netinet/in.h>

#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "discovery/beacon/network_interfaces.hpp"
#include "hgros/base/bytes.hpp"
#include "hgros/base/own_descriptor.hpp"

namespace hgros::discovery {

/// Sends to and receives from all hosts on the networks of some interfaces. Its datagrams pass no router (TTL 1).
///
/// Thread safety: Send() from any thread; the rest on one thread.
class BeaconSocket {
 public:
  struct Datagram {
    Bytes bytes;  // A part of the buffer that was passed in.
    in_addr sender{};
  };

  /// Throws Error.
  BeaconSocket(std::vector<std::string> interface_names, std::uint16_t port);

  /// Looks up the current interfaces. Returns sentences about those that cannot be used.
  std::vector<std::string> Refresh();
  /// Sends on every interface. Returns the error of one of them, or an empty text.
  [[nodiscard]] std::string Send(std::string_view datagram) const;
  /// The next datagram received on one of the interfaces; empty if there is none. Its bytes are empty if it was for
  /// another interface or too long.
  [[nodiscard]] std::optional<Datagram> Receive(std::span<std::byte> buffer);
  [[nodiscard]] int fd() const noexcept { return socket_.get(); }

 private:
  void Join(const NetworkInterface& one) noexcept;

  const std::vector<std::string> names_;
  const std::uint16_t port_;
  in_addr group_{};
  OwnDescriptor socket_;
  mutable std::mutex mutex_;
  std::vector<NetworkInterface> interfaces_;  // Written with mutex_ by the one thread, which reads them without.
};

/// "192.0.2.7".
[[nodiscard]] std::string AddressText(in_addr address);

}  // namespace hgros::discovery
