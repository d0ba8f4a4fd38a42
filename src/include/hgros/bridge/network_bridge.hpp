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
  ZmqOptions zmq;                               ///< ZeroMQ, with endpoints now or later.
  std::optional<ShmOptions> shm;                ///< Empty: no shared memory.
  std::optional<RegistryOptions> registry;      ///< Empty: no discovery on this host.
  std::vector<std::string> only;                ///< Processes of this host to connect to; empty: all.
  std::optional<BeaconOptions> beacon;          ///< Empty: no discovery of other hosts.
  std::vector<TransportEntry> more_transports;  ///< In addition to these two.
  /// By channel, the transports that it may use.
  std::map<std::string, TransportKeys, std::less<>> rules;
  std::function<void()> on_announcements;  ///< Called when announcements of this host have changed. Must not block.
  /// Runs an errand after a delay on a thread that may wait. Not called after the bridge has been closed.
  std::function<void(std::chrono::nanoseconds delay, std::function<void()> errand)> later;
};

/// Connects one session's data graph to those of other sessions: finds them on its host and its network, and receives
/// each one over the cheapest transport that reaches it, so that no message arrives twice.
///
/// Thread safety: all functions; wiring (everything that is not const) by one thread at a time. Calls into the listener
/// come from the transports' threads, in one order for each peer.
class NetworkBridge {
 public:
  /// Creates the transports of the options and starts discovery. Throws Error. `listener` and `log` must outlive it.
  NetworkBridge(BridgeOptions options, TransportListener& listener, Log& log);
  NetworkBridge(const NetworkBridge&) = delete;
  NetworkBridge& operator=(const NetworkBridge&) = delete;
  ~NetworkBridge();

  [[nodiscard]] std::shared_ptr<JoinedOutbound> Advertise(const std::string& channel, const TypeInfo& type,
                                                          OutboundSource& source);
  /// `announced`: what others see as the type, unless it stays inside this process. It may be known although messages
  /// of any type are asked for.
  [[nodiscard]] std::shared_ptr<JoinedInbound> Subscribe(const std::string& channel, const TypeInfo& type,
                                                         const TypeInfo& announced, const Demand& demand,
                                                         InboundSink& sink);
  /// The same without an announcement: the channel connects no sessions, and only those that are connected for another
  /// channel are asked for it. It ends with the result, which waits for active calls into the sink.
  [[nodiscard]] std::shared_ptr<const void> SubscribeUnannounced(const std::string& channel, const TypeInfo& type,
                                                                 const Demand& demand, InboundSink& sink);
  /// Tells others whether the session, which subscribes to the channel, asks for lossless delivery now.
  void SetLossless(const std::string& channel, bool lossless);
  /// Tells others that the session no longer subscribes to the channel.
  void EndSubscribing(const std::string& channel);
  /// Tells others that the session no longer publishes on the channel.
  void EndPublishing(const std::string& channel);

  /// As in the ZeroMQ transport, also for an endpoint that a beacon has found already. Throws Error.
  void AddPublishEndpoint(const PublishEndpoint& endpoint);
  void AddSubscribeEndpoint(const SubscribeEndpoint& endpoint);
  bool RemoveSubscribeEndpoint(const std::string& endpoint);
  void SetPublishChannels(const std::string& endpoint, ChannelList channels);
  void SetSubscribeChannels(const std::string& endpoint, ChannelList channels);
  [[nodiscard]] std::vector<std::string> BoundEndpoints() const;

  /// See ZmqTransport.
  [[nodiscard]] OrderWay SendOrder(SessionId publisher, std::string_view request);

  [[nodiscard]] std::vector<PeerInfo> Peers() const;
  [[nodiscard]] bool IsOnThisHost(SessionId peer) const;
  /// Adds the channels of other sessions: those in the registry of this host, then those that are connected.
  void ListChannels(ChannelDirectory& directory);
  /// The sessions that the host's registry lists as subscribers, and whether other sessions could subscribe.
  [[nodiscard]] ChannelSearch Search(const std::string& channel);

  /// See Transport::Receive().
  void Receive(const Visit& visit) noexcept;
  [[nodiscard]] bool ReceiveHere(const Visit& visit) noexcept;
  void WakeReceiver() noexcept;
  [[nodiscard]] TransportStats stats() const;
  /// See Transport::Leave().
  void Leave() noexcept;
  /// Sends a goodbye to all peers, and the published messages as far as Transport::Close() allows.
  void Close(int linger_ms, int at_most_ms = 0) noexcept;

 private:
  const std::unique_ptr<BridgeCore> core_;
};

}  // namespace hgros
