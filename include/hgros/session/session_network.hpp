#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/export.hpp"
#include "hgros/base/ids.hpp"
#include "hgros/bridge/known_channel.hpp"
#include "hgros/clock/clock_offset.hpp"
#include "hgros/config/config.hpp"

namespace hgros {

class SessionCore;

/// How a Session reaches others, and which others there are. Use it as a part of Session, which says how it is threaded
/// and what it throws.
class HGROS_EXPORT SessionNetwork {
 public:
  /// Adds `channel` to the white lists of the publisher endpoints, or takes it out: whether it leaves through them.
  void AllowPublishing(std::string_view channel, bool allowed);
  /// The same for the subscriber endpoints: whether it enters through them.
  void AllowSubscribing(std::string_view channel, bool allowed);

  /// Binds or connects one more endpoint. Throws Error if that is not possible.
  void AddPublisherEndpoint(const EndpointConfig& endpoint);
  void AddSubscriberEndpoint(const EndpointConfig& endpoint);
  void RemoveSubscriberEndpoint(std::string_view endpoint);
  /// Where other sessions can connect to: the real addresses, also if the system chose the port.
  [[nodiscard]] std::vector<std::string> PublisherEndpoints() const;

  /// How far the wall clock of the peer's host is ahead of ours, and how exactly that is known: zero on this host.
  /// Known one heartbeat after two sessions have met over endpoints; each heartbeat makes it better. Latencies in
  /// statistics are corrected by it. Empty for a session that is no peer or has not answered yet.
  [[nodiscard]] std::optional<ClockOffset> OffsetTo(SessionId peer) const;

  [[nodiscard]] std::vector<PeerInfo> Peers() const;
  /// All channels that the session could publish on or receive, its own among them, by name. kChannelEventsChannel
  /// tells that they change.
  [[nodiscard]] std::vector<KnownChannel> Channels() const;

 protected:
  explicit SessionNetwork(SessionCore& core) noexcept : network_core_(core) {}
  ~SessionNetwork() = default;

 private:
  SessionCore& network_core_;
};

}  // namespace hgros
