#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <shared_mutex>
#include <string>
#include <vector>

#include "transport/inbound_core.hpp"
#include "transport/leader_pool.hpp"
#include "transport/outbound_core.hpp"
#include "transport/poller.hpp"
#include "transport/zmq/arrival_wait.hpp"
#include "transport/zmq/curve.hpp"
#include "transport/zmq/publish/publisher_endpoint.hpp"
#include "transport/zmq/shared_state.hpp"
#include "transport/zmq/subscribe/subscriber_endpoint.hpp"

namespace hgros::zmq {

/// The endpoints of one transport and the threads that wait for them. The transport shares it with its channels, so
/// that these may outlive it.
///
/// Thread safety: thread-safe. Order of locks: `mutex_`, then an endpoint's, in the order of the list.
class ZmqCore : public LeaderPool::Input {
 public:
  ZmqCore(ZmqOptions options, TransportListener& listener, Log& log);
  ~ZmqCore() override;

  void Start();
  /// See Transport::Close().
  void Close(int linger_ms, int at_most_ms) noexcept;

  void AddPublisher(const PublishEndpoint& endpoint);
  void AddSubscriber(const SubscribeEndpoint& endpoint);
  bool RemovePublisher(const std::string& endpoint);
  bool RemoveSubscriber(const std::string& endpoint);
  void SetPublishChannels(const std::string& endpoint, const ChannelList& channels);
  void SetSubscribeChannels(const std::string& endpoint, const ChannelList& channels);
  [[nodiscard]] std::vector<std::string> BoundEndpoints() const;
  [[nodiscard]] std::vector<SessionChannels> KnownChannels() const;
  [[nodiscard]] std::uint64_t refused_handshakes() const {
    return shared_.refused_handshakes.load() + (desk_ ? desk_->refused() : 0);
  }

  void Offer(const std::shared_ptr<OutboundCore>& core);
  void Withdraw(const std::shared_ptr<OutboundCore>& core);
  void Want(const std::shared_ptr<InboundCore>& core);
  void Unwant(const std::shared_ptr<InboundCore>& core);
  void ChangeDemand(const std::shared_ptr<InboundCore>& core);
  /// Asks for channels whose claims are free now; only for that of `core`, if it is not null.
  void AskAgain(const InboundCore* core);
  [[nodiscard]] static bool Asks(const InboundCore& core, SessionId publisher) { return core.IsClaimed(publisher); }

  [[nodiscard]] OrderWay SendOrder(SessionId publisher, std::string_view request);

  [[nodiscard]] PublishStatus Reserve(OutboundCore& core);
  void Cancel(const std::shared_ptr<OutboundCore>& core);
  [[nodiscard]] std::size_t Unfinished(const OutboundCore& core) const;
  void Commit(const std::shared_ptr<OutboundCore>& core, const PacketHead& head, const Payload& data);

  [[nodiscard]] SharedState& shared() noexcept { return shared_; }
  /// Whether this is a forked child, which must leave everything here alone.
  [[nodiscard]] bool IsChild() const noexcept { return shared_.fork.IsChild(); }

  void Wait() noexcept override;
  LeaderPool::Task Lead() noexcept override;
  void Wake() noexcept override;

 private:
  /// The endpoints that the leading thread serves.
  struct Watch {
    std::uint64_t version = 0;
    std::vector<std::shared_ptr<PublisherEndpoint>> publishers;
    std::vector<std::shared_ptr<SubscriberEndpoint>> subscribers;
    std::vector<std::shared_ptr<SubscriberEndpoint>> removed;  // They still hold messages that they received.
  };
  void TakeOrder(InboundMessage&& order);
  /// Another session publishes where this one did.
  void OnReplaced(SessionId session);
  void UpdateWatch();
  void Tick(SteadyTime now);
  void Look(SteadyTime now);
  void SetDeadline();
  [[nodiscard]] bool Pending() const;
  [[nodiscard]] Arriving LookAtArriving();

  SharedState shared_;
  Poller poller_;
  std::atomic<bool> woken_{false};  // For the poller, which needs a flag to set. Nothing reads it.
  std::atomic<bool> desk_input_{true};
  std::unique_ptr<AdmissionDesk> desk_;
  mutable std::shared_mutex mutex_;
  std::vector<std::shared_ptr<PublisherEndpoint>> publishers_;
  std::vector<std::shared_ptr<SubscriberEndpoint>> subscribers_;
  // Closed, but calls into them may still be active. They end with the transport.
  std::vector<std::shared_ptr<PublisherEndpoint>> old_publishers_;
  // Closed, and not yet in the leading thread's list, where they end when they have delivered everything.
  std::vector<std::shared_ptr<SubscriberEndpoint>> old_subscribers_;
  std::map<std::string, std::shared_ptr<OutboundCore>> outbound_;  // By channel.
  std::map<std::string, std::shared_ptr<InboundCore>> inbound_;
  std::atomic<std::uint64_t> version_{1};
  bool closed_ = false;
  // Belong to the leading thread.
  Watch watch_;
  SteadyTime next_tick_;
  SteadyTime next_look_ = SteadyTime::max();
  // The latest time at which waiting ends. The leading thread sets it, the waiting ones read it.
  std::atomic<SteadyTime> deadline_;
  ArrivalWait arrival_;
  LeaderPool pool_{*this};
};

}  // namespace hgros::zmq
