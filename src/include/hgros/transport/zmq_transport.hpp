#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/log.hpp"
#include "hgros/transport/curve_key_pair.hpp"
#include "hgros/transport/transport.hpp"

namespace hgros {

/// Which channels may pass an endpoint; nullopt means all.
using ChannelList = std::optional<std::vector<std::string>>;

/// An endpoint that this session binds and publishes on: `tcp://*:5553`, `tcp://127.0.0.1:*` (a free port) or
/// `ipc:///path`. Without a scheme it is tcp.
struct PublishEndpoint {
  std::string endpoint;
  ChannelList channels;
};

/// What happens at a subscribe endpoint.
enum class EndpointEvent {
  kReached,  ///< A session has answered.
  kFailed,   ///< An attempt to connect has failed, and will be repeated.
  kLost,     ///< The session that has answered is gone.
};

/// An endpoint that another session publishes on. This session connects, and retries until the other one is there.
struct SubscribeEndpoint {
  std::string endpoint;
  ChannelList channels;
  std::string server_key;  ///< With ZmqSecurity: the public key of the other session.
  /// Called on the transport's threads; must not block. If it is set, failed attempts are not logged. The session is
  /// the one that has answered, if one has.
  std::function<void(EndpointEvent, SessionId)> on_event = {};
};

/// Encrypts and authenticates every connection of a transport.
struct ZmqSecurity {
  CurveKeyPair own;
  std::vector<std::string> allowed_clients;  ///< Public keys of the sessions that may subscribe here; empty: none.
};

struct ZmqOptions {
  SessionId session;    ///< None: a random one.
  std::string process;  ///< This program's name, for logs.
  std::vector<PublishEndpoint> publish;
  std::vector<SubscribeEndpoint> subscribe;
  std::chrono::milliseconds heartbeat{1000};
  std::chrono::milliseconds peer_timeout{5000};   ///< A peer that is silent for longer is gone.
  std::uint64_t peer_queue_bytes = 64ULL << 20;   ///< Maximum that waits for one slow keep-last peer.
  std::uint64_t plain_queue_bytes = 64ULL << 20;  ///< Maximum on its way to all plain subscribers of an endpoint.
  std::uint64_t max_credit_bytes = 256ULL << 20;  ///< Maximum in flight to one subscriber of a channel.
  /// A larger message is refused and the connection is closed.
  std::uint64_t max_message_bytes = kMaxMessageBytes;
  /// A publisher that has sent no welcome after being connected for this time is a plain one.
  std::chrono::milliseconds plain_after{1000};
  std::chrono::milliseconds unreachable_after{3000};  ///< A missing connection is logged after this time.
  std::chrono::milliseconds linger{500};              ///< For the destructor's Close().
  std::optional<ZmqSecurity> security;
  std::function<Time()> wall;  ///< This host's wall clock; empty: the system's.
  /// Whether to receive that session's messages on the channel here, and not over another transport. Empty: always.
  /// Must be quick, and must not call the transport.
  std::function<bool(SessionId publisher, std::string_view channel)> takes;
};

/// How an order went to a publisher; see ZmqTransport::SendOrder(). In the order in which they are preferred.
enum class OrderWay : std::uint8_t {
  kNone,    ///< No endpoint leads to it, or another transport does.
  kTooOld,  ///< Its release takes no orders.
  kSent,
};

/// Messages over ZeroMQ: ipc on one host, tcp between hosts. docs/wire-protocol.md is the specification.
///
/// Each publish endpoint is an XPUB socket, each subscribe endpoint an XSUB socket. A channel may be advertised once
/// and subscribed to once at a time. A session that is connected through several endpoints sends a channel through one
/// of them, and if that one ends, through another.
///
/// Threading: thread-safe. Publishing threads write to the sockets themselves.
/// Fork: in a forked child Reserve() returns kClosed, Commit() does nothing, wiring throws Error; destructors leave the
/// memory to the end of the process.
class ZmqTransport : public Transport {
 public:
  /// Changes which channels may pass, while running. Errors: throws Error if there is no such endpoint.
  virtual void SetPublishChannels(const std::string& endpoint, ChannelList channels) = 0;
  virtual void SetSubscribeChannels(const std::string& endpoint, ChannelList channels) = 0;

  /// Errors: throws Error if the endpoint cannot be bound (port in use, another program listens there, path too long)
  /// or was added already.
  virtual void AddPublishEndpoint(const PublishEndpoint& endpoint) = 0;
  virtual void AddSubscribeEndpoint(const SubscribeEndpoint& endpoint) = 0;
  /// Says goodbye there. Messages that a subscribe endpoint has read are still delivered. False if there is no such
  /// endpoint.
  virtual bool RemovePublishEndpoint(const std::string& endpoint) = 0;
  virtual bool RemoveSubscribeEndpoint(const std::string& endpoint) = 0;

  /// Sends a request of control to a session that this one subscribes to, over that connection. For sessions that
  /// receive nothing from here. It may be lost.
  [[nodiscard]] virtual OrderWay SendOrder(SessionId publisher, std::string_view request) = 0;

  /// The publish endpoints that others can connect to, with the actual ports, in the order in which they were added.
  [[nodiscard]] virtual std::vector<std::string> BoundEndpoints() const = 0;
  /// Connections refused because of a wrong or missing key.
  [[nodiscard]] virtual std::uint64_t refused_handshakes() const = 0;
};

/// Errors: throws Error if an endpoint or a key cannot be used. `listener` and `log` outlive the transport.
[[nodiscard]] std::unique_ptr<ZmqTransport> MakeZmqTransport(ZmqOptions options, TransportListener& listener, Log& log);

}  // namespace hgros
