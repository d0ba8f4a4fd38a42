#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bridge/announcer.hpp"
#include "bridge/host_pairs.hpp"
#include "bridge/joined/joined_inbound.hpp"
#include "bridge/joined/joined_outbound.hpp"
#include "bridge/lan_peers.hpp"
#include "bridge/open_transports.hpp"
#include "bridge/peer_transports.hpp"
#include "bridge/ruled_out_channels.hpp"
#include "hgros/base/log.hpp"
#include "hgros/bridge/network_bridge.hpp"

namespace hgros {

/// All transports of one session, and how it finds others on its host and its network. Each other session is received
/// over one transport, the cheapest that reaches it, so no message comes twice.
///
/// Thread safety: all functions; wiring (everything except stats and lists) by one thread at a time. Calls into the
/// listener come from the transports' threads, in one order for each peer.
class BridgeCore final : private DiscoveryListener {
 public:
  /// Opens the transports that the options ask for and lets others find this session. Throws Error. `listener` and
  /// `log` outlive it.
  BridgeCore(BridgeOptions options, TransportListener& listener, Log& log);
  ~BridgeCore() override;

  [[nodiscard]] std::shared_ptr<JoinedOutbound> Advertise(const std::string& channel, const TypeInfo& type,
                                                          OutboundSource& source);
  [[nodiscard]] std::shared_ptr<JoinedInbound> Subscribe(const std::string& channel, const TypeInfo& type,
                                                         const TypeInfo& announced, const Demand& demand,
                                                         InboundSink& sink);
  /// As Subscribe(), without telling others of the host.
  [[nodiscard]] std::shared_ptr<JoinedInbound> JoinInbound(const std::string& channel, const TypeInfo& type,
                                                           const Demand& demand, InboundSink& sink);
  /// Tells others whether the session, which subscribes to the channel, asks for lossless delivery now.
  void SetLossless(const std::string& channel, bool lossless);
  /// Tells others that the session no longer subscribes to the channel, or no longer publishes there.
  void EndSubscribing(const std::string& channel);
  void EndPublishing(const std::string& channel);

  /// The transport with endpoints; opened at the first call. Throws Error.
  ZmqTransport& Zmq();
  [[nodiscard]] ZmqTransport* zmq() const noexcept { return open_.zmq(); }
  /// Like the transport's function; also for an endpoint that a beacon has already reported. Throws Error.
  void AddPublishEndpoint(const PublishEndpoint& endpoint);
  void AddSubscribeEndpoint(const SubscribeEndpoint& endpoint);
  bool RemoveSubscribeEndpoint(const std::string& endpoint);

  [[nodiscard]] std::vector<PeerInfo> Peers() const { return peers_.List(); }
  /// The channels of other sessions, by their own data: first the sessions in this host's registry, then those that
  /// are connected.
  [[nodiscard]] std::vector<std::vector<SessionChannels>> KnownChannels() const;
  /// The sessions that subscribe according to this host's registry, and whether there may be others.
  [[nodiscard]] ChannelSearch Search(const std::string& channel) const;
  [[nodiscard]] bool IsOnThisHost(SessionId peer) const;
  void Receive(const Visit& visit) const noexcept { open_.Receive(visit); }
  [[nodiscard]] bool ReceiveHere(const Visit& visit) const noexcept { return open_.ReceiveHere(visit); }
  void WakeReceiver() const noexcept { open_.WakeReceiver(); }
  [[nodiscard]] TransportStats stats() const { return open_.stats(); }
  /// Says goodbye to all peers, and sends published messages for at most `linger_ms`.
  void Leave() noexcept { open_.Leave(); }
  void Close(int linger_ms, int at_most_ms) noexcept;

 private:
  /// A session that was found on this host within this time may be about to subscribe.
  static constexpr auto kTimeToSubscribe = std::chrono::seconds(1);

  // The listener of one transport.
  class Ear final : public TransportListener {
   public:
    Ear(BridgeCore& bridge, TransportIndex transport) : bridge_(bridge), transport_(transport) {}
    void OnPeerCame(const PeerInfo& peer) noexcept override;
    void OnPeerGone(const PeerInfo& peer, std::string_view reason) noexcept override;
    void OnTypeMismatch(std::string_view channel, const PeerInfo& peer, std::string_view what) noexcept override;
    void OnClockExchange(const PeerInfo& peer, const ClockExchange& exchange) noexcept override;
    void OnChannels() noexcept override { bridge_.listener_.OnChannels(); }

   private:
    BridgeCore& bridge_;
    const TransportIndex transport_;
  };

  void Open(TransportIndex transport);
  void Announce();
  [[nodiscard]] TransportKeys KeysFor(const std::string& channel) const;
  template <class Joined>
  void Join(std::vector<std::weak_ptr<Joined>>& list, const std::shared_ptr<Joined>& joined);
  void WarnIfConfined(const std::string& channel, TransportSet rule);
  void AskAgain() noexcept;

  // bridge_finding.cpp: finds other sessions of the host and the network, and lets them find us.
  void OnCame(const Announcement& peer) override;
  void OnChanged(const Announcement& peer) override;
  void OnGone(const Announcement& last, std::string_view reason) override;
  void OpenAll();
  void OpenOnHost();
  void LookOnHost();
  void AppearOnHost();
  void LookOnNetwork();
  void TellAnnouncements();

  // bridge_moving.cpp: moves a peer's messages to another transport.
  void BeginMove(SessionId peer, PeerTransports::MoveNumber number);
  void FinishMove(SessionId peer, PeerTransports::MoveNumber number);
  // The transport no longer reaches the peer.
  void EndMove(SessionId peer, TransportIndex gone);
  void MoveChannel(JoinedInbound& joined, SessionId peer);
  void ForgetForbiddenMoves(SessionId peer);
  static void EndMoves(JoinedInbound& joined, SessionId peer, const JoinedInbound::Which& which);
  void AwaitSubscriber(SessionId subscriber, JoinedOutbound::Abandon give_up);
  void GiveUpSubscriber(const PeerInfo& subscriber);
  template <class Joined>
  [[nodiscard]] std::vector<std::shared_ptr<Joined>> Listed(const std::vector<std::weak_ptr<Joined>>& list);

  TransportListener& listener_;
  Log& log_;
  const BridgeOptions options_;
  const TransportList transports_;
  const TransportRules rules_;
  PeerTransports peers_;
  std::deque<Ear> ears_;  // By transport.
  OpenTransports open_;
  std::unique_ptr<LanPeers> lan_;
  std::atomic<std::chrono::steady_clock::time_point> last_came_{std::chrono::steady_clock::now()};
  std::mutex lists_;  // Guards the members below.
  std::vector<std::weak_ptr<JoinedOutbound>> outbound_;
  std::vector<std::weak_ptr<JoinedInbound>> inbound_;
  std::atomic<bool> telling_{false};  // An errand tells that announcements have changed.
  RuledOutChannels ruled_out_;
  HostPairs pairs_;
  Announcer announcer_;  // Destroyed first, because its threads use all members above.
};

}  // namespace hgros
