#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hgros/base/log.hpp"
#include "hgros/discovery/beacon.hpp"
#include "hgros/discovery/registry.hpp"
#include "hgros/transport/shm_transport.hpp"
#include "hgros/transport/zmq_transport.hpp"
#include "session/channel_search.hpp"
#include "session/joined_channels.hpp"
#include "session/lan_peers.hpp"
#include "session/peer_carriers.hpp"

namespace hgros {

struct CarrierOptions {
  ZmqOptions zmq;                           ///< With endpoints, or for some that come later.
  std::optional<ShmOptions> shm;            ///< Nothing: no memory is shared with anybody.
  std::optional<RegistryOptions> registry;  ///< Nothing: nobody is looked for on this host.
  std::vector<std::string> only;            ///< On this host only these processes; empty: all.
  std::optional<BeaconOptions> beacon;      ///< Nothing: nobody is looked for on other hosts.
  CarrierRules rules;                       ///< By channel.
  std::function<void()> on_announcements;   ///< What sessions of this host say has changed. Must not block.
  /// Runs something after a while, on a thread that may wait; not after the carriers have been closed.
  std::function<void(std::chrono::nanoseconds delay, std::function<void()> errand)> later;
};

/// All carriers of one session, and how it finds others on its host and its network. Each other session is received
/// from over one carrier, the cheapest that reaches it, so no message comes twice.
///
/// Thread safety: all functions, but wiring (all but stats and lists) by one thread at a time. Calls into the listener
/// come from the carriers' threads, in one order for each peer.
class Carriers final : private DiscoveryListener {
 public:
  /// Makes the carriers that the options ask for and lets others find this session. Throws Error. `listener` and `log`
  /// outlive it.
  Carriers(CarrierOptions options, TransportListener& listener, Log& log);
  ~Carriers() override;

  [[nodiscard]] std::shared_ptr<JoinedOutbound> Advertise(const std::string& channel, const TypeInfo& type,
                                                          OutboundSource& source);
  [[nodiscard]] std::shared_ptr<JoinedInbound> Subscribe(const std::string& channel, const TypeInfo& type,
                                                         const Demand& demand, InboundSink& sink);
  /// For others to see: the session no longer subscribes to the channel.
  void Unannounce(const std::string& channel);
  /// Likewise: it no longer publishes there.
  void Withdraw(const std::string& channel);

  /// The one for endpoints; made at the first call. Throws Error.
  ZmqTransport& Zmq();
  [[nodiscard]] ZmqTransport* zmq() const noexcept { return zmq_.load(std::memory_order_acquire); }
  /// As the transport's, also of an endpoint to which a beacon has led already. Throws Error.
  void AddPublishEndpoint(const PublishEndpoint& endpoint);
  void AddSubscribeEndpoint(const SubscribeEndpoint& endpoint);
  bool RemoveSubscribeEndpoint(const std::string& endpoint);

  [[nodiscard]] std::vector<PeerInfo> Peers() const { return peers_.List(); }
  /// What the sessions of this host say in its registry.
  [[nodiscard]] std::vector<SessionChannels> AnnouncedChannels();
  /// Who says in the host's registry that it subscribes to the channel, and whether anybody else could.
  [[nodiscard]] ChannelSearch Search(const std::string& channel);
  [[nodiscard]] bool IsOnThisHost(SessionId peer) const;
  /// See ShmTransport::Receive.
  void Receive(const Visit& visit) noexcept { shm_ ? shm_->Receive(visit) : visit.first(); }
  [[nodiscard]] TransportStats stats() const;
  /// Says goodbye everywhere, and sends what was published as far as `linger_ms` allows.
  void Close(int linger_ms) noexcept;

 private:
  /// How long a session of this host that lives is left to shared memory.
  static constexpr auto kSharedMemoryPatience = std::chrono::seconds(2);

  /// Who was found on this host so lately may be about to subscribe.
  static constexpr auto kTimeToSubscribe = std::chrono::seconds(1);

  // One carrier's voice.
  class Ear final : public TransportListener {
   public:
    Ear(Carriers& carriers, CarrierKind kind) : carriers_(carriers), kind_(kind) {}
    void OnPeerCame(const PeerInfo& peer) noexcept override;
    void OnPeerGone(const PeerInfo& peer, std::string_view reason) noexcept override;
    void OnTypeMismatch(std::string_view channel, const PeerInfo& peer, std::string_view what) noexcept override;
    void OnClockExchange(const PeerInfo& peer, const ClockExchange& exchange) noexcept override;
    void OnChannels() noexcept override { carriers_.listener_.OnChannels(); }

   private:
    Carriers& carriers_;
    const CarrierKind kind_;
  };

  void OnCame(const Announcement& peer) override;
  void OnChanged(const Announcement& peer) override;
  void OnGone(const Announcement& last, std::string_view reason) override;

  // carriers_finding.cpp: how others of the host and the network are found, and find us.
  void OpenShm();
  void LookOnHost();
  void LookOnNetwork();
  // Under announcing_: what is said of the channel.
  ChannelAnnouncement& Own(const std::string& channel, const TypeInfo& type);
  void Announce();
  [[nodiscard]] bool IsWanted(const Announcement& peer);
  void AwaitSharedMemory(SessionId id, const std::string& process, std::int64_t pid);
  void SayLaterWhatCannotPass();
  void SayWhatCannotPass();

  [[nodiscard]] CarrierSet RuleOf(const std::string& channel) const;
  template <class Joined>
  void Join(std::vector<std::weak_ptr<Joined>>& list, const std::shared_ptr<Joined>& joined);
  void AskAgain(CarrierKind kind) noexcept;

  // carriers_moving.cpp: how a peer's messages come over another carrier than before.
  void BeginMove(SessionId peer);
  void FinishMove(SessionId peer);
  // A carrier of one that moves, or has moved, is gone.
  void EndMove(SessionId peer, CarrierKind gone);
  void MoveChannel(JoinedInbound& joined, SessionId peer);
  void ForgetRuledMoves(SessionId peer);
  void AwaitSubscriber(SessionId subscriber, std::function<void()> give_up);
  void GiveUpSubscriber(SessionId subscriber);
  template <class Joined>
  [[nodiscard]] std::vector<std::shared_ptr<Joined>> Listed(const std::vector<std::weak_ptr<Joined>>& list);

  TransportListener& listener_;
  Log& log_;
  CarrierOptions options_;
  PeerCarriers peers_;
  Ear zmq_ear_{*this, CarrierKind::kZmq};
  Ear shm_ear_{*this, CarrierKind::kShm};
  std::unique_ptr<ShmTransport> shm_;
  std::mutex announcing_;  // Guards the next two: a subscription may end while the session does.
  Announcement own_;
  std::set<std::pair<std::string, std::uint64_t>> said_;  // Channels and sessions between which nothing can pass.
  // Read by any thread, and made while others read: it stays when it is there.
  std::unique_ptr<ZmqTransport> owned_zmq_;
  std::atomic<ZmqTransport*> zmq_{nullptr};
  std::unique_ptr<LanPeers> lan_;
  std::atomic<std::chrono::steady_clock::time_point> last_came_{std::chrono::steady_clock::now()};
  std::atomic<bool> ruled_;  // Somebody has rules for channels.
  std::mutex lists_;         // Guards what follows.
  std::set<std::uint64_t> moving_;
  std::vector<std::weak_ptr<JoinedOutbound>> outbound_;
  std::vector<std::weak_ptr<JoinedInbound>> inbound_;
  // Under announcing_. They end first: their threads use all of the above.
  std::unique_ptr<Discovery> registry_;
  std::unique_ptr<Discovery> beacon_;
};

}  // namespace hgros
