#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <shared_mutex>
#include <string>
#include <vector>

#include "hgros/base/fork_guard.hpp"
#include "hgros/clock/following_clock.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/session/session.hpp"
#include "session/carriers.hpp"
#include "session/channel_inlet.hpp"
#include "session/channel_outlet.hpp"
#include "session/errand_thread.hpp"
#include "session/host_clocks.hpp"
#include "session/services.hpp"
#include "session/session_timers.hpp"
#include "session/snapshot_publisher.hpp"

namespace hgros {

// Joins the data graph to the carrier.
//
// Thread safety: all public functions from any thread.
// Invariants: mutex_ guards the wiring; neither the carrier's callbacks nor the publish path takes it, so the carrier
// may be called under it, except for what waits for callbacks: ending an inbound channel. That is done outside the
// lock, by Reconcile(), one thread per channel at a time, and from within callbacks by the errand thread.
class Session::Core final : public TransportListener, private ServicePlace {
 public:
  Core(Config config, SessionOptions options);
  ~Core() override;

  Channel& Open(std::string_view name, const TypeInfo& type, const CallSite& where);
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

  void AllowPublishing(std::string_view channel, bool allowed);
  void AllowSubscribing(std::string_view channel, bool allowed);
  void AddPublisherEndpoint(const EndpointConfig& endpoint);
  void AddSubscriberEndpoint(const EndpointConfig& endpoint);
  void RemoveSubscriberEndpoint(std::string_view endpoint);
  std::vector<std::string> PublisherEndpoints() const;

  std::vector<PeerInfo> Peers() const override;
  // Lets others be found, if that has not begun.
  std::vector<KnownChannel> Channels();
  SessionSnapshot Snapshot() const;
  std::optional<ClockOffset> OffsetTo(SessionId peer) const;

  void OnPeerCame(const PeerInfo& peer) noexcept override;
  void OnPeerGone(const PeerInfo& peer, std::string_view reason) noexcept override;
  void OnChannels() noexcept override;
  void OnTypeMismatch(std::string_view channel, const PeerInfo& peer, std::string_view what) noexcept override;
  void OnClockExchange(const PeerInfo& peer, const ClockExchange& exchange) noexcept override {
    host_clocks_->Add(peer.id, exchange);
  }

  [[nodiscard]] Services& services() noexcept { return *services_; }
  [[nodiscard]] DataGraph& graph() noexcept { return *graph_; }
  [[nodiscard]] const DataGraph& graph() const noexcept { return *graph_; }
  [[nodiscard]] SessionTimers& timers() noexcept { return *timers_; }
  [[nodiscard]] const std::shared_ptr<Clock>& clock() const noexcept { return clock_; }
  // Nothing of the session may be waited for or destroyed here.
  [[nodiscard]] bool in_forked_child() const noexcept { return fork_.IsChild(); }
  [[nodiscard]] SessionId id() const noexcept { return id_; }
  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  [[nodiscard]] Log& log() const noexcept { return *log_; }
  [[nodiscard]] Config config() const;

 private:
  // What this session's subscriptions to one channel ask of remote publishers, and how far that is put into effect.
  struct Inflow {
    std::shared_ptr<ChannelInlet> inlet;
    std::list<Demand> wanted;
    bool joined = false;
    bool busy = false;  // A thread is in Reconcile() for this channel.
  };
  // Lets subscriptions that outlive the session find out that it is gone.
  struct Alive {
    std::shared_mutex mutex;
    Core* core = nullptr;
  };
  class DemandTicket;

  // session_services.cpp: what services need.
  Subscription Listen(const std::string& channel, const TypeInfo& type, AnyCallback callback,
                      std::size_t queue_depth) override;
  std::shared_ptr<ChannelOutlet> OpenOutlet(const std::string& channel, const TypeInfo& type,
                                            OutletEvents events) override;
  void CloseOutlet(const std::string& channel, const std::shared_ptr<ChannelOutlet>& outlet) override;
  [[nodiscard]] DataGraph& Graph() override { return *graph_; }
  [[nodiscard]] ChannelSearch Search(const std::string& channel) override;
  void Report(PeerEvent event) noexcept override { PublishEvent(std::move(event)); }
  void Receive(const Visit& visit) noexcept override;

  // session_channels.cpp. Under mutex_.
  [[nodiscard]] SessionChannels OwnChannels() const;

  // Throws Error while the session shuts down.
  void RequireOpen() const;
  static constexpr int kLingerMs = 500;
  // Under mutex_: makes the carriers at the first call.
  Carriers& Reach();
  CarrierOptions OptionsForCarriers();
  // Posts to the errand thread.
  std::function<void(std::chrono::nanoseconds, std::function<void()>)> Later();
  enum class Way { kOut, kIn };
  std::string Confined(std::string_view channel, const std::vector<EndpointConfig>& endpoints, Way way) const;
  bool SayIfItCannotLeave(const std::string& channel);
  NodeOptions WithChannelConfig(const Channel& channel, NodeOptions options) const;
  void Withdraw(const std::string& channel, std::list<Demand>::iterator demand);
  // Joins or ends the inbound channel as the wanted demands say.
  void Reconcile(const std::string& channel);
  static Demand Combine(const std::list<Demand>& wanted);
  void Notify() noexcept;
  void PublishEvent(PeerEvent event) noexcept;
  std::vector<Subscription> FollowClock();

  template <class Predicate>
  bool WaitUntil(std::chrono::nanoseconds timeout, Predicate predicate) const;

  const ForkGuard fork_;
  Config config_;
  const SessionId id_;
  const std::string name_;
  const MessageId publisher_;
  const std::shared_ptr<Log> log_;
  const std::optional<std::string> domain_;
  const std::shared_ptr<HostClocks> host_clocks_;
  const std::shared_ptr<FollowingClock> followed_clock_;  // clock_, if that follows a published one
  const std::shared_ptr<Clock> clock_;

  const std::shared_ptr<Alive> alive_ = std::make_shared<Alive>();

  mutable std::mutex changed_mutex_;
  mutable std::condition_variable changed_;
  std::uint64_t changes_ = 0;

  std::atomic<bool> closing_{false};
  std::atomic<bool> telling_channels_{false};
  std::uint64_t channel_changes_ = 0;  // The errand thread's.
  mutable std::mutex mutex_;
  std::unique_ptr<DataGraph> graph_;
  std::optional<SessionTimers> timers_;
  Publisher<PeerEvent> events_;
  Publisher<ChannelsChanged> channel_events_;
  std::optional<ErrandThread> errands_;
  std::unique_ptr<Carriers> carriers_;
  std::optional<SnapshotPublisher> snapshots_;  // Made with them.
  std::map<std::string, std::shared_ptr<ChannelOutlet>, std::less<>> outlets_;
  std::vector<std::shared_ptr<ChannelOutlet>> service_outlets_;
  std::uint64_t last_incarnation_ = 0;  // Of these.
  std::map<std::string, Inflow, std::less<>> inflows_;
  std::set<std::string> said_confined_;  // Subscribed channels that were looked up in the white lists.
  std::shared_ptr<Services> services_;
  std::vector<Subscription> clock_nodes_;
};

// The predicate takes other locks, so it is asked outside this one.
template <class Predicate>
bool Session::Core::WaitUntil(std::chrono::nanoseconds timeout, Predicate predicate) const {
  const auto deadline = DeadlineIn(timeout);
  for (;;) {
    std::unique_lock lock(changed_mutex_);
    const std::uint64_t seen = changes_;
    lock.unlock();
    if (predicate()) return true;
    if (closing_) return false;
    lock.lock();
    if (!changed_.wait_until(lock, deadline, [&] { return changes_ != seen; })) return predicate();
  }
}

}  // namespace hgros
