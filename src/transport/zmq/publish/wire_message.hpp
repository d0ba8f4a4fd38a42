#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string_view>

#include "hgros/internal/codec/packet.hpp"
#include "transport/peer_channel.hpp"
#include "transport/zmq/socket.hpp"

namespace hgros::zmq {

/// Bytes of payloads that ZeroMQ holds for plain subscribers, which give no credit.
using OutstandingBytes = std::shared_ptr<std::atomic<std::uint64_t>>;

/// One message as frames, written once and sent to any number of subscribers. The head is encoded once. A small payload
/// is copied; a large one is sent in place and kept alive until the network has sent it.
///
/// Thread-safe: SendTo from any number of threads, each with its own socket's mutex.
class WireMessage final : public Outgoing {
 public:
  /// Throws std::bad_alloc.
  WireMessage(const PacketHead& head, const Payload& data);

  /// Sends topic, head and data; the caller holds the socket's mutex.
  void SendTo(Socket& socket, std::string_view topic) const noexcept;
  /// Like SendTo(), and counts the message in `outstanding` until the network has sent it.
  void SendCounted(Socket& socket, std::string_view topic, const OutstandingBytes& outstanding) const;

  [[nodiscard]] const MessageId& id() const noexcept { return id_; }
  /// The bytes that credit counts: head and data frame.
  [[nodiscard]] std::uint64_t bytes() const noexcept { return bytes_; }

 private:
  MessageId id_;
  std::uint64_t bytes_;
  mutable Message head_;
  mutable Message data_;
};

}  // namespace hgros::zmq
