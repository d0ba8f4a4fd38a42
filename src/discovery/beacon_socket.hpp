#pragma once

#include <netinet/in.h>

#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "discovery/network_interfaces.hpp"
#include "hgros/base/bytes.hpp"
#include "hgros/base/own_descriptor.hpp"

namespace hgros::discovery {

/// Sends to, and hears, everyone on the networks of some interfaces. Nothing it sends passes a router (TTL 1).
///
/// Thread safety: Send() from any thread; the rest belongs to one.
class BeaconSocket {
 public:
  struct Datagram {
    Bytes
        bytes;  // Part of the buffer that was passed in; longer than the buffer's use would be cut, so those are none.
    in_addr sender{};
  };

  /// Throws Error.
  BeaconSocket(std::vector<std::string> interface_names, std::uint16_t port);

  /// Looks which interfaces there are now.
  void Refresh();
  /// On every interface; what went wrong with one, or an empty text.
  [[nodiscard]] std::string Send(std::string_view datagram) const;
  /// The next datagram that came in on one of the interfaces; one without bytes for others and for too long ones; none
  /// when there is no more.
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
