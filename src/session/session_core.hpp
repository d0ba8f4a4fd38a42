#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "hgros/base/fork_guard.hpp"
#include "hgros/base/reserved_names.hpp"
#include "hgros/bridge/channel_inlet.hpp"
#include "hgros/bridge/channel_outlet.hpp"
#include "hgros/bridge/network_bridge.hpp"
#include "hgros/clock/errand_thread.hpp"
#include "hgros/clock/following_clock.hpp"
#include "hgros/clock/host_clocks.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/graph/graph_ending.hpp"
#include "hgros/services/services.hpp"
#include "hgros/session/session.hpp"
#include "session/change_signal.hpp"
#include "session/control/one_at_a_time.hpp"
#include "session/control/steering.hpp"
#include "session/endpoint_lists.hpp"
#include "session/inbound_channels.hpp"
#include "session/misspelled_names.hpp"
#include "session/observed/own_reports.hpp"
#include "session/outbound_channels.hpp"
#include "session/session_events.hpp"
#include "session/session_timers.hpp"

namespace hgros {

// Joins the data graph to the network bridge, and both to services, timers and events.
//
// Thread safety: all public functions from any thread.
// Invariants: mutex_ guards the bridge and the endpoints' lists. Neither the transports' callbacks nor the publish path
// wait for it, so the bridge may be called under it. It is taken before the locks of inbound_ and outbound_, never
// after.
class SessionCore final : public TransportListener, private ServicePlace {
 public:
  SessionCore(Config config, SessionOptions options);
  ~SessionCore() override;

  Channel& OpenAny(std::string_view name, const TypeInfo& type, const CallSite& where);
  std::shared_ptr<const MessageSchema> AwaitSchema(std::string_view channel, std::chrono::nanoseconds timeout);
  void Latch(Channel& channel, std::size_t count);
  Block LoanBlock(std::string_view channel, std::size_t size_bytes);
  Subscription SubscribeAny(Channel& channel, const TypeInfo& type, Invoke invoke, AnyCallback callback,
                            NodeOptions options);
  Subscription SubscribeGraph(Channel& channel, const TypeInfo& type, Invoke invoke, AnyCallback callback,
                              NodeOptions options);

  bool WaitForSubscribers(std::string_view channel, std::size_t count, std::chrono::nanoseconds timeout);
  bool WaitForPublishers(std::string_view channel, std::size_t count, std::chrono::nanoseconds timeout) const;

  void Allow(Way way, std::string_view channel, bool allowed);
  void AddPublisherEndpoint(const EndpointConfig& endpoint);
  void AddSubscriberEndpoint(const EndpointConfig& endpoint);
  void RemoveSubscriberEndpoint(std::string_view endpoint);
  std::vector<std::string> PublisherEndpoints() const;

  std::vector<PeerInfo> Peers() const override;
  // Starts discovery if it has not started yet.
  std::vector<KnownChannel> Channels();
  SessionSnapshot Snapshot() const;
  std::optional<ClockOffset> OffsetTo(SessionId peer) const;
  // Null before there is one. It stays until the session ends.
  [[nodiscard]] NetworkBridge* bridge() const { return (std::scoped_lock(mutex_), bridge_.get()); }

  void OnPeerCame(const PeerInfo& peer) noexcept override;
  void OnPeerGone(const PeerInfo& peer, std::string_view reason) noexcept override;
  void OnChannels() noexcept override;
  void OnTypeMismatch(std::string_view channel, const PeerInfo& peer, std::string_view what) noexcept override;
  void OnClockExchange(const PeerInfo& peer, const ClockExchange& exchange) noexcept override {
    host_clocks_->Add(peer.id, exchange);
  }

  [[nodiscard]] OrderWay SendOrder(SessionId publisher, std::string_view request);
  [[nodiscard]] ServicePlace& place() noexcept { return *this; }
  [[nodiscard]] OneAtATime& asking() noexcept { return asking_; }
  [[nodiscard]] Services& services() noexcept { return *services_; }
  [[nodiscard]] DataGraph& graph() noexcept { return *graph_; }
  [[nodiscard]] const DataGraph& graph() const noexcept { return *graph_; }
  [[nodiscard]] SessionTimers& timers() noexcept { return *timers_; }
  [[nodiscard]] const std::shared_ptr<Clock>& clock() const noexcept { return clock_; }
  // For the end of the session. False: nothing of it may be waited for or destroyed. This is a forked child; or one of
  // its callbacks runs here (`callback`: surely), so it takes leave of its peers and logs that; or it did so at exit().
  [[nodiscard]] bool MayBeDestroyed(std::string callback = {}) noexcept;
  [[nodiscard]] SessionId id() const noexcept { return id_; }
  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  [[nodiscard]] Log& log() const noexcept { return *log_; }
  [[nodiscard]] Config config() const { return (std::scoped_lock(mutex_), config_); }
  [[nodiscard]] std::shared_ptr<const void> TryReserve(std::string_view name) { return reserved_.TryReserve(name); }

 private:
  friend class SessionParts;
  friend class SessionServices;
  // In session_services.cpp: the ServicePlace of the services.
  Subscription Listen(const std::string& channel, const TypeInfo& type, AnyCallback callback,
                      std::size_t queue_depth) override;
  std::shared_ptr<SessionOutlet> OpenOutlet(const std::string& channel, const TypeInfo& type,
                                            OutletEvents events) override;
  void CloseOutlet(const std::string& channel, const std::shared_ptr<SessionOutlet>& outlet) override {
    outbound_.CloseForService(channel, outlet);
  }
  [[nodiscard]] DataGraph& Graph() override { return *graph_; }
  [[nodiscard]] ChannelSearch Search(const std::string& channel) override;
  [[nodiscard]] int LongestSilenceMs() const override { return config_.peer_timeout_ms + 2 * config_.heartbeat_ms; }
  [[nodiscard]] ReplyWays WaysOf(const std::string& service) const override;
  void ReportServedTwice(const PeerInfo& other, std::string channel, std::string sentence) noexcept override {
    events_->PublishPeer(*errands_, {PeerEvent::Kind::kServedTwice, other, std::move(channel), std::move(sentence)});
  }
  void Receive(const Visit& visit) noexcept override;
  [[nodiscard]] std::vector<std::string> KnownServices() override;
  // In session_channels.cpp. Call it under mutex_.
  [[nodiscard]] SessionChannels OwnChannels() const;

  // In session_leaving.cpp: the end inside a callback of the session.
  void LeavePeers(std::thread::id on_behalf_of) noexcept;
  void LeaveAtExit() noexcept;

  // Throws Error while the session shuts down. False after exit() in a callback: other threads may still wire then.
  [[nodiscard]] bool TakesWiring() const;
  static constexpr std::chrono::milliseconds kLinger{500};
  // Creates the bridge at the first call. Call it under mutex_, and not once closing_ is set.
  NetworkBridge& EnsureTransports();
  // A function that runs its argument on the errand thread after a delay.
  std::function<void(std::chrono::nanoseconds, std::function<void()>)> Later();
  bool SayIfItCannotLeave(const std::string& channel);

  template <class Predicate>
  bool WaitUntil(std::chrono::nanoseconds timeout, Predicate predicate) const {
    return changes_.WaitUntil(timeout, std::move(predicate), [this] { return ends_waits_.load(); });
  }

  const ForkGuard fork_;
  Config config_;  // Only the endpoints and their lists change, under mutex_.
  const SessionId id_;
  const std::string name_;
  const MessageId publisher_;
  const std::shared_ptr<Log> log_;
  const std::optional<std::string> domain_;
  const std::shared_ptr<HostClocks> host_clocks_;
  const std::shared_ptr<FollowingClock> followed_clock_;  // clock_ if that follows a published clock; otherwise null
  const std::shared_ptr<Clock> clock_;

  ChangeSignal changes_;
  std::atomic<bool> closing_{false};
  std::atomic<bool> ends_waits_{false};  // Not at exit(): threads that wait then would run on while the process ends.
  mutable std::mutex mutex_;
  std::unique_ptr<DataGraph> graph_;
  std::optional<SessionTimers> timers_;
  std::optional<SessionEvents> events_;
  std::optional<ErrandThread> errands_;
  std::unique_ptr<NetworkBridge> bridge_;
  std::optional<OwnReports> reports_;  // Created with the bridge.
  OutboundChannels outbound_;
  const std::shared_ptr<InboundChannels> inbound_;  // Shared with subscriptions, which may outlive the session.
  std::optional<Steering> steering_;                // Created with the bridge, unless the configuration says no.
  std::set<std::string> said_confined_;             // Subscribed channels that were looked up in the endpoints' lists.
  std::optional<MisspelledNames> misspelled_;
  ReservedNames reserved_;
  OneAtATime asking_;  // Entered while this session asks others to change something.
  std::shared_ptr<Services> services_;
  std::vector<Subscription> clock_nodes_;
};

}  // namespace hgros
