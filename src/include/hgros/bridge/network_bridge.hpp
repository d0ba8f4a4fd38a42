#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hgros/base/log.hpp"
#include "hgros/base/transport_keys.hpp"
#include "hgros/bridge/transport_list.hpp"
#include "hgros/discovery/beacon.hpp"
#include "hgros/discovery/registry.hpp"
#include "hgros/transport/channel_search.hpp"
#include "hgros/transport/shm_transport.hpp"
#include "hgros/transport/zmq_transport.hpp"

namespace hgros {

class BridgeCore;
class ChannelDirectory;
class JoinedInbound;
class JoinedOutbound;

struct BridgeOptions {
  ZmqOptions zmq;                               ///< With endpoints, or for some that come later.
  std::optional<ShmOptions> shm;                ///< Nothing: no memory is shared with anybody.
  std::optional<RegistryOptions> registry;      ///< Nothing: nobody is looked for on this host.
  std::vector<std::string> only;                ///< On this host only these processes; empty: all.
  std::optional<BeaconOptions> beacon;          ///< Nothing: nobody is looked for on other hosts.
  std::vector<TransportEntry> more_transports;  ///< Besides those two.
  /// By channel, the transports that it may use.
  std::map<std::string, TransportKeys, std::less<>> rules;
  std::function<void()> on_announcements;  ///< What sessions of this host say has changed. Must not block.
  /// Runs something after a while, on a thread that may wait; not after the bridge has been closed.
  std::function<void(std::chrono::nanoseconds delay, std::function<void()> errand)> later;
};

/// Joins one session's data graph to those of others: finds them on its host and its network, and receives each over
/// the cheapest transport that reaches it, so that no message comes twice.
///
/// Thread safety: all functions; wiring (everything that is not const) by one thread at a time. Calls into the listener
/// come from the transports' threads, in one order for each peer.
class NetworkBridge {
 public:
  /// Makes the transports that the options ask for and lets others find this session. Throws Error. `listener` and
  /// `log` outlive it.
  NetworkBridge(BridgeOptions options, TransportListener& listener, Log& log);
  NetworkBridge(const NetworkBridge&) = delete;
  NetworkBridge& operator=(const NetworkBridge&) = delete;
  ~NetworkBridge();

  [[nodiscard]] std::shared_ptr<JoinedOutbound> Advertise(const std::string& channel, const TypeInfo& type,
                                                          OutboundSource& source);
  [[nodiscard]] std::shared_ptr<JoinedInbound> Subscribe(const std::string& channel, const TypeInfo& type,
                                                         const Demand& demand, InboundSink& sink);
  /// Tells others that the session no longer subscribes to the channel.
  void EndSubscribing(const std::string& channel);
  /// Tells others that the session no longer publishes there.
  void EndPublishing(const std::string& channel);

  /// As the transport's, also of an endpoint to which a beacon has led already. Throws Error.
  void AddPublishEndpoint(const PublishEndpoint& endpoint);
  void AddSubscribeEndpoint(const SubscribeEndpoint& endpoint);
  bool RemoveSubscribeEndpoint(const std::string& endpoint);
  void SetPublishChannels(const std::string& endpoint, ChannelList channels);
  void SetSubscribeChannels(const std::string& endpoint, ChannelList channels);
  [[nodiscard]] std::vector<std::string> BoundEndpoints() const;

  [[nodiscard]] std::vector<PeerInfo> Peers() const;
  [[nodiscard]] bool IsOnThisHost(SessionId peer) const;
  /// Adds what other sessions say of their channels: those of this host in its registry, then those that are connected.
  void ListChannels(ChannelDirectory& directory);
  /// The sessions that say in the host's registry that they subscribe, and whether others could.
  [[nodiscard]] ChannelSearch Search(const std::string& channel);

  /// See Transport::Receive().
  void Receive(const Visit& visit) noexcept;
  [[nodiscard]] TransportStats stats() const;
  /// Says goodbye everywhere, and sends what was published as far as `linger_ms` allows.
  void Close(int linger_ms) noexcept;

 private:
  const std::unique_ptr<BridgeCore> core_;
};

}  // namespace hgros
